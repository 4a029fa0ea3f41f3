//! What documents show, as programs and people write them.

use crate::sketch::{Choice, Config, Imported, from_svg};

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
