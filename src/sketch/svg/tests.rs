//! What documents show, as programs and people write them.

use crate::sketch::{Choice, Config, Imported, WarningCode, YAxis, from_svg};

/// A creature that looks to the right, standing on the ground.
const CREATURE: &str =
    r##"<path fill="#222" d="M60 70H200V40H270V70L220 85 200 120 198 180H184V120H76V180H62L60 100 30 60 36 56Z"/>"##;

fn read(document: &str) -> Imported {
    from_svg(document.as_bytes(), Choice { vertices: 200, figure: 0 }, &Config::default()).unwrap()
}

/// What a document of this root and inside shows.
fn shown(root: &str, inside: &str) -> Imported {
    read(&format!(r#"<svg xmlns="http://www.w3.org/2000/svg" {root}>{inside}</svg>"#))
}

const SHEET: &str = r#"viewBox="0 0 300 200""#;

/// The box of the figure, in whole user units.
fn place(imported: &Imported) -> [[f64; 2]; 2] {
    imported.figures[0].bounds.map(|corner| corner.map(f64::round))
}

/// What is said of what is not drawn.
fn ignored(imported: &Imported) -> String {
    let mut warnings = imported.warnings.iter().filter(|warning| warning.code == WarningCode::IgnoredElements);
    warnings.next().map(|warning| warning.detail.clone()).unwrap_or_default()
}

/// What is said of what is not drawn of this beside a creature.
fn told(inside: &str) -> String {
    ignored(&shown(SHEET, &format!("{CREATURE}{inside}")))
}

#[test]
fn transforms_move_the_same_in_styles_as_in_attributes() {
    let body = r##"<rect x="60" y="70" width="140" height="50" fill="#222"/>"##;
    let head = |way: &str| format!(r##"{body}<rect {way} y="20" width="70" height="36" fill="#222"/>"##);
    let meant = shown(SHEET, &head(r#"transform="translate(175 20) rotate(-20)""#));
    let in_sheet = "<style>.head{transform:translate(175px,20px) rotate(-20deg)}</style>";
    for inside in [
        head(r#"style="transform:translate(175px, 20px) rotate(-20deg)""#),
        head(r#"transform="translateX(175px) translateY(20px) rotate(-20deg)""#),
        format!("{in_sheet}{}", head(r#"class="head""#)),
    ] {
        assert!(shown(SHEET, &inside) == meant, "{inside}");
    }
}

#[test]
fn points_are_user_units_however_the_view_box_is_written() {
    let body = r#"<path d="M-80 -30H40V30H-80Z"/>"#;
    for view_box in ["-100 -50 200 100", "-100-50 200 100", "-1e2,-50, 200 1.e2"] {
        let seen = shown(&format!(r#"width="400" height="200" viewBox="{view_box}""#), body);
        assert_eq!(place(&seen), [[-80.0, -30.0], [40.0, 30.0]], "{view_box}");
    }
}

#[test]
fn points_are_user_units_also_where_the_root_is_mirrored() {
    let sheet = r#"<style>.back{transform:scaleX(-1)}</style>"#;
    for (root, y_axis) in [
        ("", YAxis::Down),
        (r#"transform="matrix(-1,0,0,1,0,0)""#, YAxis::Down),
        (r#"class="back""#, YAxis::Down),
        (r#"style="transform:translate(9px) scale(.5)""#, YAxis::Down),
        (r#"transform="scale(-1,.5)" transform-origin="50% 0""#, YAxis::Down),
        (r#"transform="scale(1,-1)""#, YAxis::Up),
        (r#"transform="rotate(180)""#, YAxis::Up),
    ] {
        let seen = shown(&format!("{SHEET} width='300' height='200' {root}"), &format!("{sheet}{CREATURE}"));
        assert_eq!(seen.sketch.y_axis(), y_axis, "{root}");
        assert_eq!(ignored(&seen), "", "{root}");
        assert_eq!(place(&seen), [[30.0, 40.0], [270.0, 180.0]], "{root}");
    }
    let turned = shown(&format!(r#"{SHEET} transform="rotate(-30)""#), CREATURE);
    assert!(ignored(&turned).contains("turned"));
}

#[test]
fn what_nothing_shows_is_not_told_as_left_out() {
    let picture = r#"<image id="i" width="9" height="9"/>"#;
    for inside in [
        format!("<defs><text>a</text>{picture}</defs>"),
        format!(r#"<symbol id="s">{picture}</symbol>"#),
        r#"<g style="display: none"><text>a</text></g><text display="none">b</text>"#.to_owned(),
        "<style>@media (prefers-color-scheme: dark){path{fill:#fff}} @font-face{font-family:a} a:hover{scale:2} g{isolation:isolate}</style>"
            .to_owned(),
        r#"<g style="transform:none;rotate:none;clip-path:url(#c)"/>"#.to_owned(),
    ] {
        assert_eq!(told(&inside), "", "{inside}");
    }
    for inside in [
        format!("{picture}<defs><text>a</text></defs>"),
        format!(r##"<defs>{picture}</defs><use href="#i"/>"##),
        format!(r##"<defs><pattern id="p">{picture}</pattern></defs><style>.a{{fill:url(#p)}}</style>"##),
    ] {
        assert_eq!(told(&inside), "not drawn: image", "{inside}");
    }
}

#[test]
fn style_that_is_not_read_is_named_as_it_is_written() {
    for (inside, names) in [
        ("<g style='translate:0 10px;rotate:10deg'/>", "rotate, translate"),
        ("<style>.a{scale:2} rect{transform-box:fill-box}</style>", "scale, transform-box"),
        ("<g transform='translate(50%, 0)'/>", "transform"),
        ("<style>g{transform:perspective(9px)}</style>", "transform"),
        ("<path style=\"d:path('M0 0h9')\"/><g style='clip-path:circle(4px at 1px 1px)'/>", "clip-path, d"),
        ("<style>circle{r:60px;cx:150px}</style>", "cx, r"),
        ("<style>path{vector-effect:non-scaling-stroke}</style>", "vector-effect"),
        ("<style>@media (min-width:1px){.h{display:none}} g:not(.x) .h{display:none}</style>", ":not, @media"),
    ] {
        assert_eq!(told(inside), format!("of its style not read: {names}"), "{inside}");
    }
    let both = told("<text>a</text><g style='scale:2'/>");
    assert_eq!(both, "not drawn: text; of its style not read: scale");
}

#[test]
fn a_line_that_is_not_scaled_is_as_wide_as_on_the_page() {
    let sheet = r#"width="800" height="600" viewBox="0 0 8 6""#;
    let shape = |own: &str| format!(r##"<g stroke="#000" stroke-width="60px"><path {own} d="M1 1H7V5H1Z"/></g>"##);
    let area = |root: &str, inside: &str| shown(root, inside).figures[0].area;
    let (unscaled, by_style) = (r#"vector-effect="non-scaling-stroke""#, "vector-effect:non-scaling-stroke");
    let meant = area(sheet, &shape(r#"stroke-width=".6""#));
    for inside in [
        shape(unscaled),
        shape(&format!(r#"{unscaled} stroke-width="60""#)),
        shape(&format!(r#"style="{by_style}""#)),
        shape(&format!("{unscaled} style='stroke-width:9px;stroke-width:60'")),
        format!(r#"<g transform="scale(.01)"><g transform="scale(100)">{}</g></g>"#, shape(unscaled)),
        format!(r#"<g transform="scale(.1)">{}</g>"#, shape(unscaled).replace("M1 1H7V5H1Z", "M10 10H70V50H10Z")),
    ] {
        let found = area(sheet, &inside);
        assert!((found / meant - 1.0).abs() < 1e-3, "{found} and not {meant}: {inside}");
    }
    // Without a size of its own it is as wide as its page.
    assert!(area(r#"viewBox="0 0 8 6""#, &shape(&format!(r#"{unscaled} stroke-width="2""#))) < 25.0);
}
