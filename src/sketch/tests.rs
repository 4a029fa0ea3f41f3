use super::*;

/// Two triangles that share an edge, and `more` vertices and triangles.
fn flat(more: &[[f64; 2]], triangles: &[[u32; 3]]) -> Result<Sketch, Refusal> {
    let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let positions = square.iter().chain(more).map(|&[x, y]| [x, y, 0.0]).collect();
    let triangles = [[0, 1, 2], [0, 2, 3]].iter().chain(triangles).copied().collect();
    Sketch::new(TriangleMesh::new(positions, triangles).unwrap(), YAxis::Up)
}

#[test]
fn a_sketch_is_one_figure_of_all_vertices() {
    assert!(flat(&[], &[]).is_ok());
    let apart = [[5.0, 0.0], [6.0, 0.0], [5.0, 1.0]];
    for refused in [flat(&apart[..1], &[]), flat(&apart, &[[4, 5, 6]])] {
        assert_eq!(refused.unwrap_err().to_string(), "the sketch is not one connected figure");
    }
}

fn svg(paths: &[String]) -> Result<Imported, Refusal> {
    let paths: String = paths.iter().map(|d| format!(r#"<path d="{d}"/>"#)).collect();
    let text = format!(r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 1000 1000">{paths}</svg>"#);
    from_svg(text.as_bytes(), Choice { vertices: DEFAULT_TARGET_VERTICES, figure: 0 }, &Config::default())
}

#[test]
fn an_svg_that_paints_one_place_too_often_is_refused() {
    let page = || "M10 10H990V990H10Z".to_owned();
    assert!(svg(&[page()]).is_ok());
    let refusal = svg(&vec![page(); 4000]).unwrap_err();
    assert!(refusal.to_string().contains("too many times over"), "{refusal}");
}

#[test]
fn lines_that_cross_however_often_are_read() {
    let stroke = |i: usize| format!("{} {} ", i * 617 % 1000, i % 2 * 1000);
    let zigzag = |strokes: usize| format!("M{}Z", (0..strokes).map(stroke).collect::<String>());
    for strokes in [20, 2000] {
        svg(&[zigzag(strokes)]).unwrap();
    }
}

#[test]
fn a_picture_that_is_not_drawn_is_named_before_the_blank_round_it() {
    let text = r##"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 80 60"><rect width="80" height="60" fill="#fff"/>
        <image width="80" height="60" href="elsewhere.png"/></svg>"##;
    let refusal = from_svg(text.as_bytes(), Choice { vertices: 100, figure: 0 }, &Config::default()).unwrap_err();
    assert!(refusal.faults[0].detail.contains("send that picture itself"), "{refusal}");
    assert!(refusal.faults[1].detail.contains("one colour"), "{refusal}");
}

#[test]
fn a_hairline_is_seen_and_one_that_is_covered_is_not() {
    let read = |body: &str| {
        let text = format!(r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 30000 20000">{body}</svg>"#);
        from_svg(text.as_bytes(), Choice { vertices: 200, figure: 0 }, &Config::default())
    };
    let line = r##"<path d="M9000 5000H21000V15000H9000Z" fill="none" stroke="#f00" stroke-width="1"/>"##;
    let page = r##"<path d="M0 0H30000V20000H0Z" fill="#fff"/>"##;
    for body in [line.to_owned(), format!("{page}{line}")] {
        let area = read(&body).unwrap().sketch.mesh().area();
        assert!((area / 1.2e8 - 1.0).abs() < 0.03, "{area}");
    }
    assert!(read(&format!("{line}{page}")).unwrap_err().to_string().contains("one colour"));
}
