use std::io::Cursor;

use image::{DynamicImage, GrayImage, ImageFormat, Luma, Rgb, RgbImage, Rgba, RgbaImage};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::mesh::edges::Edges;
use crate::sketch::ring::signed_area;
use crate::sketch::{Choice, Config, Imported, Refusal, Warning, WarningCode, from_picture, from_svg};

/// A person with arms and legs apart, in a box of 300 × 400 at (50, 50).
const PERSON: &str = "150 50 250 50 250 130 350 130 350 180 250 180 250 300 290 450 230 450 200 320 170 450 110 450 \
                      150 300 150 180 50 180 50 130 150 130";

fn svg(content: &str) -> Result<Imported, Refusal> {
    let text = format!(r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 400 500">{content}</svg>"#);
    from_svg(text.as_bytes(), Choice { vertices: 300, figure: 0 }, &Config::default())
}

fn area(read: Result<Imported, Refusal>) -> f64 {
    read.unwrap().sketch.mesh().area()
}

/// The area of the person as it is filled.
fn whole() -> f64 {
    area(svg(&format!(r#"<polygon points="{PERSON}"/>"#)))
}

fn is_whole(read: Result<Imported, Refusal>) -> bool {
    let ratio = area(read) / whole();
    eprintln!("{ratio:.3} of the figure's area");
    (0.96..1.04).contains(&ratio)
}

fn codes(read: &Imported) -> Vec<WarningCode> {
    read.warnings.iter().map(|warning| warning.code).collect()
}

fn png(picture: RgbImage) -> Result<Imported, Refusal> {
    let mut bytes = Cursor::new(Vec::new());
    DynamicImage::ImageRgb8(picture).write_to(&mut bytes, ImageFormat::Png).unwrap();
    from_picture(bytes.get_ref(), Choice { vertices: 300, figure: 0 }, &Config::default())
}

/// The corners of the person.
fn corners() -> Vec<[f64; 2]> {
    let numbers: Vec<f64> = PERSON.split_whitespace().map(|word| word.parse().unwrap()).collect();
    numbers.chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect()
}

/// Whether a point lies in the person, by the number of edges on its right.
fn is_in_person([x, y]: [f64; 2]) -> bool {
    let corners = corners();
    let edges = corners.iter().zip(corners.iter().cycle().skip(1));
    edges.filter(|(p, q)| (p[1] > y) != (q[1] > y) && x < p[0] + (y - p[1]) / (q[1] - p[1]) * (q[0] - p[0])).count() % 2
        == 1
}

/// The person in one colour on a ground, 400 × 500 pixels.
fn person(colour: impl Fn(u32, u32) -> [u8; 3], ground: impl Fn(u32, u32) -> [u8; 3]) -> RgbImage {
    RgbImage::from_fn(400, 500, |x, y| {
        let inside = is_in_person([f64::from(x) + 0.5, f64::from(y) + 0.5]);
        Rgb(if inside { colour(x, y) } else { ground(x, y) })
    })
}

#[test]
fn a_fill_is_its_figure_to_a_pixel() {
    let area = signed_area(&corners()).abs();
    assert!((whole() / area - 1.0).abs() < 0.01, "{} for {area}", whole());
}

#[test]
fn a_line_is_what_it_encloses_whatever_the_pen() {
    let line =
        |pen: f64| svg(&format!(r#"<polygon points="{PERSON}" fill="none" stroke="black" stroke-width="{pen}"/>"#));
    for pen in [1.5, 4.0, 10.0] {
        assert!(is_whole(line(pen)), "a pen of {pen}");
    }
    // Half of so wide a line is a third of the figure more.
    assert!((area(line(20.0)) / whole() - 1.0).abs() < 0.12);
    let filled = format!(r##"<polygon points="{PERSON}" fill="#fc8" stroke="black" stroke-width="8"/>"##);
    assert!(is_whole(svg(&filled)));
}

#[test]
fn a_fill_within_a_line_is_a_part_of_the_figure() {
    let line = format!(r#"<polygon points="{PERSON}" fill="none" stroke="black" stroke-width="4"/>"#);
    for part in [r#"<circle cx="220" cy="90" r="8"/>"#, r##"<path fill="#c22" d="M150 180h100v120h-100z"/>"##] {
        assert!(is_whole(svg(&format!("{line}{part}"))), "{part}");
    }
    // Where half of the figure is filled as darkly as the line is, the line counts in full.
    let half = r##"<path fill="#229" d="M150 50h50v270l-30 130h-60l40-150z"/>"##;
    assert!((area(svg(&format!("{line}{half}"))) / whole() - 1.04).abs() < 0.04);
}

#[test]
fn gaps_are_closed_and_named() {
    // Three strokes with gaps of 8 at (250, 240) and (200, 50), 2 % of the height.
    let strokes =
        "M204 50H250V130H350V180H250V236M250 244V300L290 450H230L200 320L170 450H110L150 300V180H50V130H150V50H196";
    let read = svg(&format!(r#"<path d="{strokes}" fill="none" stroke="black" stroke-width="4"/>"#));
    let warnings = read.as_ref().unwrap().warnings.clone();
    let gaps: Vec<[f64; 2]> =
        warnings.iter().filter(|w| w.code == WarningCode::ClosedGap).filter_map(|w| w.point).collect();
    assert!(
        gaps.iter().any(|&[x, y]| (x - 250.0).hypot(y - 240.0) < 8.0 || (x - 200.0).hypot(y - 50.0) < 8.0),
        "{gaps:?}"
    );
    assert!(is_whole(read));
}

#[test]
fn a_line_that_stays_open_is_refused_with_the_place() {
    let open = "M150 100V300H330V100H186";
    let refusal = svg(&format!(r#"<path d="{open}" fill="none" stroke="black" stroke-width="3"/>"#)).unwrap_err();
    assert!(refusal.to_string().contains("stays open"), "{refusal}");
    let [x, y] = refusal.faults[0].point.unwrap();
    assert!((x - 168.0).abs() < 25.0 && (y - 100.0).abs() < 25.0, "{refusal}");
}

#[test]
fn a_head_apart_is_joined() {
    let body = "150 150 250 150 250 300 290 450 230 450 200 320 170 450 110 450 150 300";
    let read = svg(&format!(r#"<circle cx="200" cy="95" r="40"/><polygon points="{body}"/>"#)).unwrap();
    // The neck's corners are finer than so few vertices can be.
    assert!(
        [&[WarningCode::JoinedParts][..], &[WarningCode::JoinedParts, WarningCode::Simplified]]
            .contains(&&codes(&read)[..])
    );
    let low = (0..read.sketch.mesh().positions().len()).map(|v| read.sketch.point(v)[1]).fold(f64::INFINITY, f64::min);
    assert!((low - 55.0).abs() < 2.0, "{low}");
}

#[test]
fn sticks_become_limbs() {
    let sticks = r#"<path d="M200 150V320M120 200H280M200 320L140 460M200 320L260 460" fill="none" stroke="black" stroke-width="3"/>"#;
    let read =
        svg(&format!(r#"<circle cx="200" cy="110" r="40" fill="none" stroke="black" stroke-width="3"/>{sticks}"#));
    assert!(codes(read.as_ref().unwrap()).contains(&WarningCode::LineAsLimb));
    let head = std::f64::consts::PI * 40.0 * 40.0;
    assert!(area(read) > head + 8.0 * (170.0 + 160.0 + 2.0 * 150.0));
}

#[test]
fn strokes_that_do_not_meet_make_one_runner() {
    let strokes = "M70 210L170 160L250 220H340M215 255L190 330L240 380V460M170 385L120 440H60";
    let read = svg(&format!(
        r#"<g fill="none" stroke="black" stroke-width="24"><circle cx="300" cy="95" r="40"/><path d="{strokes}"/></g>"#
    ));
    let read = read.unwrap();
    assert_eq!(read.figures.len(), 1);
    assert!(!codes(&read).contains(&WarningCode::OtherFigure), "{:?}", read.warnings);
}

#[test]
fn of_two_figures_the_other_is_named() {
    let two = r#"<rect x="20" y="100" width="100" height="300"/><rect x="260" y="80" width="120" height="320"/>"#;
    let read = svg(two).unwrap();
    let [warning] = &read.warnings[..] else { panic!("{:?}", read.warnings) };
    assert_eq!(warning.code, WarningCode::OtherFigure);
    let [low, high] = warning.bounds.unwrap();
    assert!((low[0] - 20.0).abs() < 1.0 && (high[1] - 400.0).abs() < 1.0, "{warning:?}");
    assert!((read.sketch.mesh().area() / (120.0 * 320.0) - 1.0).abs() < 0.01);
    assert_eq!(read.figures.len(), 2);
    assert_eq!(read.figures[1].bounds, [low, high]);
    let text = format!(r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 400 500">{two}</svg>"#);
    let other = |figure| from_svg(text.as_bytes(), Choice { vertices: 300, figure }, &Config::default());
    assert!((area(other(1)) / (100.0 * 300.0) - 1.0).abs() < 0.01);
    assert!(other(2).unwrap_err().to_string().contains("figure 2 was asked for; the drawing shows 2"));
}

#[test]
fn true_holes_are_kept_and_eyes_are_filled() {
    let disc = std::f64::consts::PI * 150.0 * 150.0;
    let round = "M200 100A150 150 0 0 1 200 400A150 150 0 0 1 200 100Z";
    let hole = "M180 180V320H220V180Z";
    let read = svg(&format!(r#"<path d="{round}{hole}" fill-rule="evenodd"/>"#));
    assert!((area(read) / (disc - 40.0 * 140.0) - 1.0).abs() < 0.01);
    let eye = format!(r#"<path d="{round}"/><circle cx="140" cy="180" r="12" fill="white"/>"#);
    assert!((area(svg(&eye)) / disc - 1.0).abs() < 0.01);
}

#[test]
fn what_is_hidden_is_not_seen() {
    let person = format!(r#"<polygon points="{PERSON}"/>"#);
    for hidden in [
        r#"<rect width="400" height="500" opacity="0"/>"#,
        r#"<g clip-path="url(#c)"><rect width="400" height="500"/></g><clipPath id="c"><rect width="1" height="1"/></clipPath>"#,
        r##"<rect x="2" y="2" width="390" height="490" fill="#fff"/>"##,
    ] {
        assert!(is_whole(svg(&format!("{hidden}{person}"))), "{hidden}");
    }
    let over = r##"<rect x="100" y="300" width="200" height="180" fill="#fff"/>"##;
    assert!(area(svg(&format!("{person}{over}"))) < 0.8 * whole());
}

#[test]
fn a_white_figure_without_a_page_is_seen() {
    assert!(is_whole(svg(&format!(r##"<polygon points="{PERSON}" fill="#fff"/>"##))));
}

/// A picture without a page as a PNG.
fn cut_out(pixel: impl Fn(u32, u32) -> [u8; 4]) -> Result<Imported, Refusal> {
    let mut bytes = Cursor::new(Vec::new());
    let picture = RgbaImage::from_fn(400, 500, |x, y| Rgba(pixel(x, y)));
    DynamicImage::ImageRgba8(picture).write_to(&mut bytes, ImageFormat::Png).unwrap();
    from_picture(bytes.get_ref(), Choice { vertices: 300, figure: 0 }, &Config::default())
}

#[test]
fn a_pale_coat_cut_out_of_a_photograph_is_a_part_of_its_figure() {
    let coat = |x: u32, y: u32| match (100..300).contains(&y) {
        true => [250 + ((x * 7 + y * 3) % 6) as u8; 3],
        false => [120, 90, 60],
    };
    let read = cut_out(|x, y| {
        let [r, g, b] = coat(x, y);
        let opacity = if is_in_person([f64::from(x) + 0.5, f64::from(y) + 0.5]) { 255 } else { 0 };
        [r, g, b, opacity]
    });
    assert!(is_whole(read));
}

#[test]
fn what_is_clipped_away_takes_no_room() {
    let clipped = r#"<clipPath id="c"><path d="M150 200H250V300H150Z"/></clipPath><path clip-path="url(#c)" d="M0 0H400V500H0Z"/>"#;
    let read = svg(clipped).unwrap();
    // To a pixel of a canvas that shows nothing else, not of one that shows all of the shape.
    let [low, high] = read.figures[0].bounds;
    assert!(
        [low[0] - 150.0, low[1] - 200.0, high[0] - 250.0, high[1] - 300.0].iter().all(|off| off.abs() < 0.2),
        "{low:?} {high:?}"
    );
}

#[test]
fn colours_tell_the_figure_from_the_ground() {
    let dark_below = |_, y| if y < 240 { [250, 214, 180] } else { [30, 30, 60] };
    let white = |_, _| [255; 3];
    assert!(is_whole(png(person(dark_below, white))));
    assert!(is_whole(png(person(|_, _| [255, 240, 60], white))));
    // About as bright as each other.
    assert!(is_whole(png(person(|_, _| [200, 30, 30], |_, _| [10, 105, 10]))));
    let sky_and_grass = |_, y| if y < 330 { [150, 200, 240] } else { [90, 160, 70] };
    assert!(is_whole(png(person(|_, _| [120, 70, 30], sky_and_grass))));
    let shade = |x: u32, y: u32| [(250 - x / 3) as u8 - (y / 20) as u8; 3];
    assert!(is_whole(png(person(|_, _| [20; 3], shade))));
}

#[test]
fn frames_and_papers_are_not_the_figure() {
    let frame = |x: u32, y: u32| if x < 8 || y < 8 || x >= 392 || y >= 492 { [0; 3] } else { [255; 3] };
    let table = |x: u32, y: u32| if x < 30 || y < 25 || x >= 380 || y >= 480 { [60, 50, 45] } else { [235, 232, 228] };
    for ground in [frame, table] {
        let read = png(person(|_, _| [20; 3], ground));
        assert!(codes(read.as_ref().unwrap()).contains(&WarningCode::Background));
        assert!(is_whole(read));
    }
    let is_line = |x: u32| x % 20 == 10;
    let squares = |x: u32, y: u32| if is_line(x) || is_line(y) { [190, 200, 225] } else { [255; 3] };
    assert!(is_whole(png(person(|_, _| [20; 3], squares))));
}

#[test]
fn a_scene_and_a_blank_are_refused_in_words() {
    let mut source = ChaCha8Rng::seed_from_u64(5);
    let texture: Vec<u8> = (0..25 * 20).map(|_| source.random_range(0..=255)).collect();
    let scene = RgbImage::from_fn(400, 500, |x, y| {
        let value = texture[(y / 20 * 20 + x / 20) as usize];
        Rgb([value, 255 - value, value / 2 + (x % 20) as u8])
    });
    assert!(png(scene).unwrap_err().to_string().contains("scene"));
    assert!(png(RgbImage::from_pixel(300, 300, Rgb([240; 3]))).unwrap_err().to_string().contains("one colour"));
}

#[test]
fn an_embedded_image_is_named() {
    let image = r#"<image width="10" height="10" href="data:image/png;base64,iVBORw0KGgo="/>"#;
    assert!(svg(image).unwrap_err().to_string().contains("embedded image"));
}

#[test]
fn all_that_is_left_out_has_its_box() {
    let stray = [[20, 20, 60, 30], [330, 420, 380, 470], [20, 440, 30, 490]];
    let spots = |x: u32, y: u32| stray.iter().any(|&[l, t, r, b]| (l..r).contains(&x) && (t..b).contains(&y));
    let read = png(person(|_, _| [20; 3], |x, y| if spots(x, y) { [0; 3] } else { [255; 3] })).unwrap();
    for [left, top, right, bottom] in stray.map(|corners| corners.map(f64::from)) {
        let is_named = |warning: &Warning| {
            warning.bounds.is_some_and(|[low, high]| {
                low[0] <= left + 2.0 && low[1] <= top + 2.0 && high[0] >= right - 2.0 && high[1] >= bottom - 2.0
            })
        };
        assert!(read.warnings.iter().any(is_named), "{:?}", read.warnings);
    }
}

#[test]
fn short_strokes_are_one_line() {
    let corners = corners();
    let mut strokes = String::new();
    for (p, q) in corners.iter().zip(corners.iter().cycle().skip(1)) {
        let length = (q[0] - p[0]).hypot(q[1] - p[1]);
        let at = |along: f64| [0, 1].map(|i| p[i] + (q[i] - p[i]) * (along / length).min(1.0));
        for k in 0..(length / 21.0).ceil() as usize {
            let ([x, y], [u, v]) = (at(21.0 * k as f64), at(21.0 * k as f64 + 14.0));
            strokes += &format!("M{x} {y}L{u} {v}");
        }
    }
    let read = svg(&format!(r#"<path d="{strokes}" stroke="black" stroke-width="4"/>"#));
    let gaps = codes(read.as_ref().unwrap()).iter().filter(|&&code| code == WarningCode::ClosedGap).count();
    assert!((1..=12).contains(&gaps), "{gaps} gaps");
    assert!(is_whole(read));
}

#[test]
fn a_hill_and_a_gradient_behind_a_figure_are_ground() {
    let person = format!(r##"<polygon points="{PERSON}" fill="#311"/>"##);
    let hill = r##"<path d="M0 380C100 340 300 400 400 360V500H0Z" fill="#9c6"/>"##;
    let sky = r##"<path d="M0 0H400V500H0Z" fill="#eee"/>"##;
    let gradient = r##"<linearGradient id="g" x2="0" y2="1"><stop stop-color="#fff"/><stop offset="1" stop-color="#889"/></linearGradient><path d="M0 0H400V500H0Z" fill="url(#g)"/>"##;
    for ground in [format!("{sky}{hill}"), hill.to_owned(), gradient.to_owned()] {
        let read = svg(&format!("{ground}{person}"));
        assert_eq!(codes(read.as_ref().unwrap()).iter().filter(|&&code| code == WarningCode::CutByBorder).count(), 0);
        assert!(is_whole(read), "{ground}");
    }
}

#[test]
fn rules_across_the_paper_are_no_part_of_the_figure() {
    let rules = |x: u32, y: u32| match (x, y) {
        (30, _) => [230, 120, 120],
        (_, y) if y % 28 == 5 => [170, 190, 225],
        _ => [252, 252, 248],
    };
    assert!(is_whole(png(person(|_, _| [20; 3], rules))));
}

/// How far a point is from the outline of the person, and how far along it the nearest place lies, in pixels.
fn beside_outline([x, y]: [f64; 2]) -> (f64, f64) {
    let corners = corners();
    let (mut nearest, mut passed) = ((f64::INFINITY, 0.0), 0.0);
    for (p, q) in corners.iter().zip(corners.iter().cycle().skip(1)) {
        let length = (q[0] - p[0]).hypot(q[1] - p[1]);
        let along = ((x - p[0]) * (q[0] - p[0]) + (y - p[1]) * (q[1] - p[1])) / length;
        let t = along.clamp(0.0, length) / length;
        let away = (x - p[0] - t * (q[0] - p[0])).hypot(y - p[1] - t * (q[1] - p[1]));
        if away < nearest.0 {
            nearest = (away, passed + t * length);
        }
        passed += length;
    }
    nearest
}

/// A photograph of the person drawn in a line of two pixels on a paper of some brightness and noise; how much of the light the
/// line takes at a place of it, and what else at a place of the paper.
fn photographed([light, noise]: [f64; 2], line: impl Fn(f64) -> f64, paper: impl Fn(u32, u32) -> f64) -> RgbImage {
    let mut source = ChaCha8Rng::seed_from_u64(7);
    RgbImage::from_fn(400, 500, |x, y| {
        let (away, along) = beside_outline([f64::from(x) + 0.5, f64::from(y) + 0.5]);
        let covered = (1.5 - away).clamp(0.0, 1.0) * line(along);
        let noise = noise * (0..4).map(|_| source.random_range(-1.0..1.0)).sum::<f64>();
        Rgb([(light * (1.0 - covered.max(paper(x, y))) + noise).clamp(0.0, 255.0) as u8; 3])
    })
}

#[test]
fn a_pencil_line_is_one_where_it_is_faint() {
    // Twice in a hundred pixels it is so faint that single pixels of the paper are darker.
    let pressed = |along: f64| if along.rem_euclid(50.0) < 12.0 { 0.06 } else { 0.3 };
    assert!(is_whole(png(photographed([245.0, 5.0], pressed, |_, _| 0.0))));
}

#[test]
fn a_drawing_photographed_in_little_light_is_read() {
    assert!(is_whole(png(photographed([110.0, 0.7], |_| 0.16, |_, _| 0.0))));
}

#[test]
fn a_crease_of_the_paper_is_no_part_of_the_figure() {
    // It swerves by a pixel and a half, and ends before the lower border.
    let swerve = |y: u32| 200.0 + 0.03 * f64::from(y) + 1.5 * (f64::from(y) / 60.0).sin();
    let crease =
        |end: u32| move |x: u32, y: u32| if y < end && (f64::from(x) - swerve(y)).abs() < 1.0 { 0.2 } else { 0.0 };
    for end in [500, 490] {
        assert!(is_whole(png(photographed([235.0, 5.0], |_| 0.6, crease(end)))), "a crease of {end} pixels");
    }
}

/// The share of the light that a soft crease takes which swerves by five pixels and ends before it is across, and the side of it on
/// which there is less light.
fn soft_crease(along: f64, aside: f64) -> f64 {
    let beside = aside - 200.0 - 0.03 * along - 5.0 * (along / 90.0).sin();
    let fold = 0.3 * (-(beside / 4.0).powi(2)).exp() * if along < 400.0 { 1.0 } else { 0.0 };
    fold.max(if beside > 0.0 { 0.1 } else { 0.0 })
}

#[test]
fn a_soft_crease_between_halves_of_other_shades_is_no_part_of_the_figure() {
    let down = photographed([235.0, 3.0], |_| 0.5, |x, y| soft_crease(f64::from(y), f64::from(x)));
    assert!(is_whole(png(down)));
    let across = photographed([235.0, 3.0], |_| 0.5, |x, y| soft_crease(f64::from(x), f64::from(y) - 60.0));
    let ratio = area(png(across)) / whole();
    assert!((ratio - 1.0).abs() < 0.015, "{ratio}");
}

#[test]
fn rings_of_a_sketchbook_are_no_part_of_the_figure() {
    let rings = |x: u32, y: u32| {
        let (across, along) = (f64::from(x), f64::from(y % 24) - 12.0);
        let is_ring = across < 14.0 && along.abs() < 2.0 || (across - 16.0).hypot(along) < 5.0;
        if is_ring { 0.8 } else { 0.0 }
    };
    let sketched = photographed([235.0, 4.0], |_| 0.25, rings);
    assert!(is_whole(png(sketched.clone())));
    assert!(is_whole(png(image::imageops::rotate180(&sketched))));
}

#[test]
fn a_horizon_behind_a_figure_in_lines_is_no_part_of_it() {
    for horizon in ["M0 240H150M250 240H400", "M0 250L150 262M250 270L400 282"] {
        let path = format!(r#"<path d="{horizon}" stroke="black" stroke-width="2"/>"#);
        let page = r##"<path d="M0 0H400V500H0Z" fill="#fff"/>"##;
        assert!(is_whole(svg(&format!("{page}{}{path}", drawn_in_lines()))), "{horizon}");
    }
}

#[test]
fn white_parts_in_a_dark_outline_are_no_holes() {
    // A coat with white sleeves and white boots; the colour of the fills runs a little into the line.
    let coat = r##"<path d="M150 130h100v170h-100z" fill="#e9a23b"/><path d="M150 50h100v80h-100z" fill="#f4d2b0"/>"##;
    let trousers = r##"<path d="M150 300H250L270 375H215L200 320L185 375H130Z" fill="#5b8fd0"/>"##;
    let seams = r#"<path d="M150 130v50M250 130v50M130 375h55M215 375h55" stroke="black" stroke-width="5"/>"#;
    let line = format!(r#"<polygon points="{PERSON}" fill="none" stroke="black" stroke-width="5"/>"#);
    assert!(is_whole(svg(&format!("{coat}{trousers}{seams}{line}"))));
}

#[test]
fn lines_of_the_paper_do_not_part_its_shadow() {
    // A soft shadow from the lower right corner.
    let light = |x: u32, y: u32| 1.0 - 0.5 / (1.0 + ((640.0 - f64::from(x + y)) / 60.0).exp());
    let shaded = |[r, g, b]: [u8; 3], light: f64| [r, g, b].map(|value| (f64::from(value) * light) as u8);
    let rules = |_: u32, y: u32| y % 24 < 2;
    let squares = |x: u32, y: u32| x % 24 < 2 || y % 24 < 2;
    for is_line in [&rules as &dyn Fn(u32, u32) -> bool, &squares] {
        let paper = |x, y| shaded(if is_line(x, y) { [150, 175, 220] } else { [250, 248, 242] }, light(x, y));
        assert!(is_whole(png(person(|x, y| shaded([40, 40, 60], light(x, y)), paper))));
    }
}

#[test]
fn a_figure_on_a_disc_is_told_from_a_face() {
    let disc = r##"<circle cx="200" cy="250" r="199" fill="#fc6"/>"##;
    let person = format!(r#"<polygon points="{PERSON}" transform="translate(80 100) scale(.6)"/>"#);
    let read = svg(&format!("{disc}{person}"));
    assert!(codes(read.as_ref().unwrap()).contains(&WarningCode::Background));
    assert!((area(read) / (0.36 * whole()) - 1.0).abs() < 0.05);
    let face = r#"<circle cx="140" cy="200" r="20"/><circle cx="260" cy="200" r="20"/><path d="M110 300H290A90 60 0 0 1 110 300Z"/>"#;
    let round = area(svg(&format!("{disc}{face}")));
    assert!((round / (std::f64::consts::PI * 199.0 * 199.0) - 1.0).abs() < 0.02, "{round}");
}

#[test]
fn shadows_are_left_out_and_named() {
    let person = format!(r##"<polygon points="{PERSON}" fill="#d62"/>"##);
    let thrown = format!(r##"<polygon points="{PERSON}" fill="#bbb" transform="translate(10 10)"/>"##);
    let floor = r##"<ellipse cx="200" cy="450" rx="150" ry="14" fill="#ccc"/>"##;
    for shadow in [&thrown, floor] {
        let read = svg(&format!("{shadow}{person}"));
        assert!(codes(read.as_ref().unwrap()).contains(&WarningCode::LeftOut));
        assert!(is_whole(read), "{shadow}");
    }
}

#[test]
fn a_figure_that_only_touches_the_border_is_not_cut() {
    let disc = |x: f64| {
        let round = move |px: u32, py: u32| (f64::from(px) - x).hypot(f64::from(py) - 250.0) < 120.0;
        codes(&png(RgbImage::from_fn(400, 500, |px, py| Rgb(if round(px, py) { [20; 3] } else { [255; 3] }))).unwrap())
    };
    assert!(!disc(120.0).contains(&WarningCode::CutByBorder));
    assert!(disc(60.0).contains(&WarningCode::CutByBorder));
}

#[test]
fn a_head_over_shoulders_is_joined_however_large_it_is() {
    let bust = r#"<circle cx="200" cy="150" r="90"/><path d="M80 400C80 300 130 260 200 260S320 300 320 400Z"/>"#;
    assert_eq!(codes(&svg(bust).unwrap()), [WarningCode::JoinedParts]);
}

#[test]
fn a_small_picture_is_no_larger_than_it_was_drawn() {
    let large = person(|_, _| [20; 3], |_, _| [255; 3]);
    let small = image::imageops::resize(&large, 80, 100, image::imageops::FilterType::Triangle);
    let ratio = area(png(small)) * 25.0 / whole();
    assert!((ratio - 1.0).abs() < 0.05, "{ratio}");
}

/// A JPEG with an Exif segment that says how it is to be turned.
fn turned(orientation: u8) -> Vec<u8> {
    let picture =
        GrayImage::from_fn(300, 200, |x, y| Luma([if x < 150 && y < 100 && x > 20 && y > 20 { 0 } else { 255 }]));
    let mut bytes = Cursor::new(Vec::new());
    DynamicImage::ImageLuma8(picture).write_to(&mut bytes, ImageFormat::Jpeg).unwrap();
    let entry = [1, 18, 0, 3, 0, 0, 0, 1, 0, orientation, 0, 0];
    let tiff = [&b"MM\0\x2a\0\0\0\x08\0\x01"[..], &entry, &[0; 4]].concat();
    let segment = [&b"Exif\0\0"[..], &tiff].concat();
    let length = (segment.len() + 2) as u16;
    let bytes = bytes.into_inner();
    [&bytes[..2], &[0xff, 0xe1], &length.to_be_bytes(), &segment, &bytes[2..]].concat()
}

#[test]
fn a_picture_is_read_as_it_is_shown() {
    let corner = |orientation: u8| {
        let sketch =
            from_picture(&turned(orientation), Choice { vertices: 60, figure: 0 }, &Config::default()).unwrap().sketch;
        let points = (0..sketch.mesh().positions().len()).map(|v| sketch.point(v));
        points.fold([f64::INFINITY; 2], |low, p| [low[0].min(p[0]), low[1].min(p[1])]).map(f64::round)
    };
    assert_eq!(corner(1), [21.0, 21.0]);
    assert_eq!(corner(3), [150.0, 100.0]);
    assert_eq!(corner(6), [100.0, 21.0]);
    assert_eq!(corner(8), [21.0, 150.0]);
}

#[test]
fn lines_within_a_figure_are_kept_where_they_were_drawn() {
    let body = r##"<path d="M100 100H300V400H100Z" fill="#f0c8a0" stroke="#000" stroke-width="8"/>"##;
    let eye = r#"<circle cx="150" cy="150" r="8"/>"#;
    let mouth = r##"<path d="M130 220H200" stroke="#000" stroke-width="6"/>"##;
    let read = svg(&format!("{body}{eye}{mouth}")).unwrap();
    let strokes = read.sketch.drawn_strokes();
    assert_eq!(strokes.len(), 2, "{strokes:?}");
    let (left, right) = (strokes[0][0], strokes[0][strokes[0].len() - 1]);
    let ends = if left[0] < right[0] { [left, right] } else { [right, left] };
    for (end, truth) in ends.iter().zip([[130.0, 220.0], [200.0, 220.0]]) {
        assert!((end[0] - truth[0]).hypot(end[1] - truth[1]) < 6.0, "{strokes:?}");
    }
    for point in &strokes[1] {
        assert!((point[0] - 150.0).hypot(point[1] - 150.0) < 6.0, "{strokes:?}");
    }
    // A body alone has none, filled or as a line.
    assert!(svg(body).unwrap().sketch.strokes().is_empty());
    assert!(svg(&body.replace("#f0c8a0", "none")).unwrap().sketch.strokes().is_empty());
}

#[test]
fn a_light_eye_of_a_dark_figure_is_kept() {
    let read = svg(r##"<path d="M150 100H250L330 250V400H70V250Z"/><circle cx="150" cy="220" r="8" fill="#fff"/>"##);
    let strokes = read.unwrap().sketch.drawn_strokes();
    assert_eq!(strokes.len(), 1, "{strokes:?}");
    assert!(strokes[0].iter().all(|point| (point[0] - 150.0).hypot(point[1] - 220.0) < 6.0), "{strokes:?}");
}

#[test]
fn many_pieces_left_out_are_all_told_of() {
    let spots = (0..60).map(|k| format!(r#"<circle cx="{}" cy="{}" r="6"/>"#, 20 + 30 * (k % 12), 20 + 22 * (k / 12)));
    let read = svg(&format!(r#"<path d="M60 250H340V480H60Z"/>{}"#, spots.collect::<String>())).unwrap();
    let left_out: Vec<_> = read.warnings.iter().filter(|warning| warning.code == WarningCode::LeftOut).collect();
    assert_eq!(left_out.len(), 41, "{left_out:?}");
    assert!(left_out[40].detail.starts_with("20 further pieces"), "{left_out:?}");
}

#[test]
fn an_arm_that_lies_against_the_body_is_apart_from_it() {
    let body = r##"<path d="M150 60H250L330 200V480H70V200Z" fill="#f0c8a0" stroke="#000" stroke-width="6"/>"##;
    let arms = r##"<path d="M130 480V200M270 480V200" stroke="#000" stroke-width="6"/>"##;
    let belt = r##"<path d="M73 300H327" stroke="#000" stroke-width="6"/>"##;
    let whole = svg(body).unwrap();
    let length = |read: &Imported| {
        let edges = Edges::of(read.sketch.mesh().triangles());
        let ends = edges.iter().filter(|edge| edge.half_edges().len() == 1).map(|edge| edge.ends());
        let far = |[a, b]: [u32; 2]| {
            let [p, q] = [a, b].map(|v| read.sketch.point(v as usize));
            (p[0] - q[0]).hypot(p[1] - q[1])
        };
        ends.map(far).sum::<f64>()
    };
    // Each slit is gone along on both sides.
    let armed = svg(&format!("{body}{arms}")).unwrap();
    assert!((length(&armed) - length(&whole) - 4.0 * 280.0).abs() < 60.0, "{} {}", length(&armed), length(&whole));
    // A line across parts nothing.
    let belted = svg(&format!("{body}{belt}")).unwrap();
    assert!((length(&belted) - length(&whole)).abs() < 10.0);
    assert_eq!(belted.sketch.strokes().len(), 1);
}

/// What is drawn, in a group that is made smaller and moved.
fn moved(scale: f64, by: [f64; 2], content: &str) -> String {
    format!(r#"<g transform="translate({} {}) scale({scale})">{content}</g>"#, by[0], by[1])
}

fn drawn_in_lines() -> String {
    format!(r#"<polygon points="{PERSON}" fill="none" stroke="black" stroke-width="4"/>"#)
}

#[test]
fn pieces_of_a_line_are_no_figure() {
    let pieces = "M320 250q15-12 30 0t30 0M264 406q15 12 30 0t30 0M137 445q15-12 30 0t30 0M35 337q15 12 30 0t30 0M35 163q15-12 30 \
                  0t30 0M137 55q15 12 30 0t30 0M264 94q15-12 30 0t30 0";
    let refusal = svg(&format!(r#"<path d="{pieces}" fill="none" stroke="black" stroke-width="3"/>"#)).unwrap_err();
    assert!(refusal.to_string().contains("falls into pieces"), "{refusal}");
}

#[test]
fn a_line_of_dashes_is_a_line() {
    for dashes in ["8 10", "2 7", "20 12"] {
        let style = format!("fill: none; stroke: black; stroke-width: 2; stroke-dasharray: {dashes}");
        let read = svg(&format!(r#"<polygon points="{PERSON}" style="{style}"/>"#));
        assert_eq!(codes(read.as_ref().unwrap()), []);
        assert!(is_whole(read), "{dashes}");
    }
}

#[test]
fn a_drawing_in_lines_that_goes_on_over_the_canvas_ends_there() {
    let document = |content: &str| {
        let text = format!(r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 400 250">{content}</svg>"#);
        from_svg(text.as_bytes(), Choice { vertices: 300, figure: 0 }, &Config::default())
    };
    let bust = area(document(&format!(r#"<polygon points="{PERSON}"/>"#)));
    let read = document(&drawn_in_lines());
    assert!(codes(read.as_ref().unwrap()).contains(&WarningCode::CutByBorder));
    let ratio = area(read) / bust;
    assert!((0.97..1.03).contains(&ratio), "{ratio}");
}

#[test]
fn a_line_that_runs_along_a_rule_stays() {
    let rule = |k: usize| format!(r##"<path d="M0 {0}H400" stroke="#9bd" stroke-width="1.5"/>"##, 18 + 32 * k);
    let rules: String = (0..15).map(rule).collect();
    let margin = r##"<path d="M30 0V500" stroke="#e88" stroke-width="1.5"/>"##;
    assert!(is_whole(svg(&format!("{rules}{margin}{}", drawn_in_lines()))));
}

#[test]
fn a_gap_far_from_the_legs_does_not_close_what_is_between_them() {
    // The legs are 10 apart at the feet, the line is open by 10 on the back.
    let line = "M195 60H120L60 200V450H190V430H170V250H230V430H200V450H340V200L280 60H205";
    let read = svg(&format!(r#"<path d="{line}" fill="none" stroke="black" stroke-width="3"/>"#)).unwrap();
    assert_eq!(codes(&read), [WarningCode::ClosedGap]);
    let drawn = 280.0 * 390.0 - 60.0 * 140.0 - 60.0 * 180.0 - 10.0 * 20.0;
    let ratio = read.sketch.mesh().area() / drawn;
    assert!((0.97..1.03).contains(&ratio), "{ratio}");
}

#[test]
fn what_a_figure_stands_on_is_no_part_of_it() {
    let filled = format!(r#"<polygon points="{PERSON}"/>"#);
    let straight = r#"<path d="M10 450H390" stroke="black" stroke-width="5"/>"#;
    let wavy = r#"<path d="M10 456Q100 446 200 455T390 452" fill="none" stroke="black" stroke-width="5"/>"#;
    for (figure, floor) in
        [(&filled, straight), (&drawn_in_lines(), straight), (&filled, wavy), (&drawn_in_lines(), wavy)]
    {
        let read = svg(&moved(0.9, [20.0, 20.0], &format!("{figure}{floor}")));
        let left_out = codes(read.as_ref().unwrap()).contains(&WarningCode::LeftOut);
        let ratio = area(read) / (0.81 * whole());
        assert!(left_out && (0.95..1.05).contains(&ratio), "{ratio} of {figure} on {floor}");
    }
}

#[test]
fn soles_are_no_floor() {
    let animal = "60 150 340 150 340 400 290 400 290 270 110 270 110 400 60 400";
    let filled = area(svg(&format!(r#"<polygon points="{animal}"/>"#)));
    let lines = area(svg(&format!(r#"<polygon points="{animal}" fill="none" stroke="black" stroke-width="3"/>"#)));
    assert!((lines / filled - 1.0).abs() < 0.03, "{lines} for {filled}");
}

#[test]
fn a_hole_behind_a_thin_limb_is_one() {
    // The hand on the hip: an upper arm of 16 in width, the rest of it of 5.
    let body = "M150 100H250V440H150ZM250 160H310V240H250V235H305V176H250Z";
    let apart = area(svg(&format!(r#"<path d="{body}"/>"#)));
    let drawn = 100.0 * 340.0 + 60.0 * 80.0 - 55.0 * 59.0;
    assert!((apart / drawn - 1.0).abs() < 0.03, "{apart} for {drawn}");
}

#[test]
fn a_head_that_is_a_ring_is_whole_on_a_filled_body() {
    let body = r#"<path d="M150 180H250V440H150ZM250 200H310V280H250V275H305V216H250Z"/>"#;
    let head = |inner: &str| {
        area(svg(&format!(r#"{body}<circle cx="200" cy="130" r="45" stroke="black" stroke-width="24" {inner}/>"#)))
    };
    let (ring, disc) = (head(r#"fill="none""#), head(""));
    assert!((ring / disc - 1.0).abs() < 0.01, "{ring} for {disc}");
    // What is behind the arm stays open.
    let expected = 100.0 * 260.0 + 60.0 * 80.0 - 55.0 * 59.0 + std::f64::consts::PI * 57.0 * 57.0;
    assert!((disc / expected - 1.0).abs() < 0.05, "{disc} for {expected}");
}

#[test]
fn thin_legs_of_a_filled_figure_whose_feet_nearly_meet_stay_apart() {
    let legs = "L240 430H229V450H204V422H232L248 250H152L168 422H196V450H171V430H160L130 250";
    let apart = area(svg(&format!(r#"<path d="M60 60H340V250H270{legs}H60Z"/>"#)));
    assert!((apart / 60_176.0 - 1.0).abs() < 0.02, "{apart}");
}

#[test]
fn the_inside_of_a_very_wide_line_is_no_hole() {
    let marker = r#"<ellipse cx="200" cy="220" rx="120" ry="150" fill="none" stroke="black" stroke-width="36"/>
                    <path d="M110 330h70v120h-70zM220 330h70v120h-70z"/>"#;
    let inside = std::f64::consts::PI * 120.0 * 150.0;
    assert!(area(svg(marker)) > inside);
}

#[test]
fn what_is_drawn_beside_a_figure_in_lines_stays_apart() {
    let tree = r#"<circle cx="470" cy="250" r="80" fill="none" stroke="black" stroke-width="4"/>"#;
    let read = svg(&moved(0.7, [0.0, 20.0], &format!("{}{tree}", drawn_in_lines()))).unwrap();
    assert_eq!(read.figures.len(), 2);
    assert!((read.sketch.mesh().area() / (0.49 * whole()) - 1.0).abs() < 0.05);
}

#[test]
fn a_grey_figure_is_told_from_its_own_soft_shadow() {
    let shadow = r#"<filter id="s"><feDropShadow dx="0" dy="6" stdDeviation="5" flood-opacity="0.25"/></filter>"#;
    let read = svg(&format!(r##"{shadow}<polygon points="{PERSON}" fill="#d0d0d0" filter="url(#s)"/>"##));
    let ratio = area(read) / whole();
    // The darkest of the shadow is as dark as the figure and is taken for its rim.
    assert!((0.96..1.15).contains(&ratio), "{ratio}");
}

#[test]
fn a_paper_whose_desk_shows_at_two_sides_is_the_sheet() {
    let desk = |x: u32, y: u32| [150 + (x * 7 % 5 * 12 + y * 3 % 7 * 6) as u8, 110 + (x * 3 % 7 * 8) as u8, 60];
    let ground = |x: u32, y: u32| if x < 22 || y < 18 + x / 20 { desk(x, y) } else { [226, 224, 220] };
    let read = png(person(|_, _| [30; 3], ground));
    assert!(codes(read.as_ref().unwrap()).contains(&WarningCode::Background));
    assert!(is_whole(read));
}

#[test]
fn a_paper_with_another_beside_it_is_the_sheet() {
    // Both lie on dark wood, and what is drawn on neither reaches a corner of the picture.
    let wood = |x: u32, y: u32| [90 + (x * 7 % 5 * 12 + y * 3 % 7 * 6) as u8, 60 + (x * 3 % 7 * 8) as u8, 40];
    let grain = |x: u32, y: u32| (x * 13 + y * 7) as u8 % 4;
    let ground = |x: u32, y: u32| {
        let is_paper = (22..378).contains(&x) && (30..470).contains(&y);
        let is_other = x < 60 && y < 120 && !is_paper;
        let light = if is_paper { 226 } else { 190 };
        if is_paper || is_other { [light + grain(x, y); 3] } else { wood(x, y) }
    };
    let read = png(person(|x, y| [30 + grain(x, y); 3], ground));
    assert!(codes(read.as_ref().unwrap()).contains(&WarningCode::Background));
    assert!(is_whole(read));
}

#[test]
fn the_shade_along_the_border_of_a_scan_is_no_part_of_the_figure() {
    let shade = |x: u32, y: u32| {
        let within = f64::from((400 - x).min(500 - y));
        if within < 14.0 { 0.5 - 0.03 * within } else { 0.0 }
    };
    assert!(is_whole(png(photographed([245.0, 1.0], |_| 0.6, shade))));
}

#[test]
fn a_frame_of_any_width_is_not_the_figure() {
    for width in [4, 8, 10, 14, 20] {
        let frame = format!(r#"<path d="M15 15H385V485H15Z" fill="none" stroke="black" stroke-width="{width}"/>"#);
        let read = svg(&format!(r#"{frame}<polygon points="{PERSON}"/>"#));
        assert!(is_whole(read), "{width}");
    }
}

#[test]
fn sky_between_legs_in_the_grass_is_no_part_of_the_figure() {
    let ground = |_: u32, y: u32| if y < 430 { [190, 225, 255] } else { [110, 185, 80] };
    assert!(is_whole(png(person(|_, _| [120, 80, 50], ground))));
}

#[test]
fn what_runs_over_one_corner_of_the_sheet_is_the_figure() {
    let is_animal = |x: u32, y: u32| x >= 180 && y >= 300 || (120..=180).contains(&x) && (320..380).contains(&y);
    let picture = RgbImage::from_fn(400, 500, |x, y| Rgb(if is_animal(x, y) { [170, 102, 51] } else { [255; 3] }));
    let shown = 220.0 * 200.0 + 60.0 * 60.0;
    let ratio = area(png(picture)) / shown;
    assert!((0.95..1.05).contains(&ratio), "{ratio}");
}

#[test]
fn a_checkerboard_is_what_is_transparent() {
    let square = |x: u32, y: u32| if (x / 12 + y / 12).is_multiple_of(2) { [255; 3] } else { [204; 3] };
    let is_transparent = |read: &Imported| codes(read).contains(&WarningCode::Background);
    let grey = png(person(|_, _| [180, 180, 188], square));
    assert!(is_transparent(grey.as_ref().unwrap()) && is_whole(grey));
    // A coat of one of the greys in a dark outline is seen as on white.
    let line = |[x, y]: [f64; 2]| beside_outline([x, y]).0 < 6.0;
    let outlined = |x: u32, y: u32| if line([f64::from(x), f64::from(y)]) { [30; 3] } else { [255; 3] };
    let coat = png(person(outlined, square)).unwrap();
    let ratio = coat.sketch.mesh().area() / area(png(person(outlined, |_, _| [255; 3])));
    assert!(is_transparent(&coat) && (ratio - 1.0).abs() < 0.01, "{ratio}");
}

#[test]
fn a_pencil_beside_the_drawing_stays_there() {
    let pencil = r##"<path d="M480 90L500 470" stroke="#b80" stroke-width="20"/>"##;
    let read = svg(&moved(0.7, [0.0, 20.0], &format!("{}{pencil}", drawn_in_lines()))).unwrap();
    assert!((read.sketch.mesh().area() / (0.49 * whole()) - 1.0).abs() < 0.05, "{:?}", read.figures);
    // A leg that does not quite reach the body does.
    let walker = svg(r#"<path d="M100 60H300V260H100Z"/><path d="M140 300V460" stroke="black" stroke-width="16"/>"#);
    assert_eq!(walker.unwrap().figures.len(), 1);
}

#[test]
fn a_cloud_and_a_caption_beside_a_filled_figure_are_no_parts_of_it() {
    let cloud = r#"<ellipse cx="60" cy="60" rx="55" ry="30" fill="none" stroke="black" stroke-width="3"/>"#;
    let caption = r##"<path d="M10 30H130V85H10Z" fill="#fe8"/>"##;
    for beside in [cloud, caption] {
        let read = svg(&format!(r#"<polygon points="{PERSON}"/>{beside}"#));
        assert!(is_whole(read), "{beside}");
    }
}

#[test]
fn a_figure_on_a_patch_of_colour_is_told_from_an_animal_with_one_on_its_back() {
    let patch =
        r##"<path d="M200 20C330 10 390 110 380 240S350 480 190 480S0 400 30 240S90 30 200 20Z" fill="#fcc"/>"##;
    let person = |scale: f64| {
        moved(scale, [200.0 * (1.0 - scale), 250.0 * (1.0 - scale)], &format!(r#"<polygon points="{PERSON}"/>"#))
    };
    let read = svg(&format!("{patch}{}", person(0.7)));
    assert!(codes(read.as_ref().unwrap()).contains(&WarningCode::Background));
    assert!((area(read) / (0.49 * whole()) - 1.0).abs() < 0.05);
    let back = r#"<ellipse cx="200" cy="260" rx="110" ry="140"/>"#;
    let all = area(svg(patch));
    assert!((area(svg(&format!("{patch}{back}"))) / all - 1.0).abs() < 0.02);
}

#[test]
fn a_figure_in_parts_on_a_disc_is_seen() {
    let disc = r##"<circle cx="200" cy="250" r="199" fill="#c33"/>"##;
    let parts = r#"<path fill="white" d="M130 200H270V262H130ZM130 270H270V340H130ZM130 345H190V400H130ZM210 345H270V400H210Z"/>"#;
    let read = svg(&format!(r#"{disc}{parts}<circle cx="200" cy="165" r="30" fill="white"/>"#)).unwrap();
    assert!(codes(&read).contains(&WarningCode::Background));
    assert!(read.sketch.mesh().area() < 30_000.0, "{}", read.sketch.mesh().area());
}

#[test]
fn the_canvas_in_the_window_of_a_program_is_the_sheet() {
    let window = r##"<path d="M0 0H400V500H0Z" fill="#f4f4f4"/><path d="M20 40H330V480H20Z" fill="#c8ccd2"/>
                     <path d="M330 60H390V90H330ZM340 120H400V140H340Z" fill="#8ac"/>"##;
    let canvas = r##"<path d="M40 60H310V460H40Z" fill="white"/>"##;
    let read =
        svg(&format!(r#"{window}{canvas}{}"#, moved(0.6, [55.0, 110.0], &format!(r#"<polygon points="{PERSON}"/>"#))));
    assert!(codes(read.as_ref().unwrap()).contains(&WarningCode::Background));
    assert!((area(read) / (0.36 * whole()) - 1.0).abs() < 0.05);
}
