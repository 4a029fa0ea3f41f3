use image::RgbImage;

use super::colour::{Colour, difference};
use super::fixtures::{cube, square_on};
use super::*;
use crate::mesh::solids::sphere;
use crate::sketch::YAxis;

fn decoded(bytes: &[u8]) -> RgbImage {
    image::load_from_memory(bytes).unwrap().into_rgb8()
}

fn is_near(a: [u8; 3], b: [u8; 3], tolerance: u8) -> bool {
    a.iter().zip(b).all(|(x, y)| x.abs_diff(y) <= tolerance)
}

/// Columns of a row that are not white.
fn covered(picture: &RgbImage, row: u32, columns: std::ops::Range<u32>) -> Vec<u32> {
    columns.filter(|&x| picture.get_pixel(x, row).0 != [255; 3]).collect()
}

#[test]
fn a_cube_seen_from_the_front_is_a_square_in_the_colours_of_the_sketch() {
    let (mesh, sketch) = (cube(), square_on(&cube()));
    let pair = sketch.pair(&mesh);
    let picture = decoded(&png(&pair, WIDTH).unwrap());
    let Scene { height, figures } = scene::scene(&pair, WIDTH);
    assert_eq!(picture.dimensions(), (WIDTH, height));
    for figure in &figures[..2] {
        let window = figure.window.left..figure.window.left + figure.window.width;
        let x = figure.points.iter().map(|p| f64::from(window.start) + p[0]);
        let (left, right) = (x.clone().fold(f64::INFINITY, f64::min), x.fold(0.0, f64::max));
        for row in [100, height / 2, height - 100] {
            let columns = covered(&picture, row, window.clone());
            assert!(
                (f64::from(columns[0]) - left).abs() < 2.0 && (f64::from(*columns.last().unwrap()) - right).abs() < 2.0
            );
            assert_eq!(columns.len() as u32, columns.last().unwrap() - columns[0] + 1);
        }
    }
    // Ten pixels inside the corners the mesh has the sketch's colours in less light.
    let (corner, lit) = (figures[0].points[0], figures[1].points[4]);
    let at = |figure: usize, p: [f64; 3]| {
        let x = f64::from(figures[figure].window.left) + p[0] + 10.0;
        picture.get_pixel(x as u32, (p[1] - 10.0) as u32).0
    };
    let drawn = at(0, corner);
    assert!(is_near(drawn, scene::colours(&pair).0[0].bytes(), 16), "{drawn:?}");
    let seen = at(1, lit);
    assert!(seen.iter().zip(drawn).all(|(&x, y)| x <= y + 4 && x >= y / 2), "{seen:?} {drawn:?}");
}

#[test]
fn what_is_hidden_stays_hidden() {
    // The far side of the cube is answered, and it is looked at from the front.
    let (mesh, sketch) = (cube(), square_on(&cube()));
    let far = Matched { vertices: vec![0, 1, 3, 2], ..sketch.pair(&mesh) };
    let Scene { height, figures } = scene::scene(&far, WIDTH);
    let front = raster::Raster::of(&figures[1]).seen(figures[1].triangles.len());
    let facing = |t: &usize| mesh.triangles()[*t].iter().all(|&v| v >= 4);
    assert_eq!((0..12).filter(|&t| front[t]).collect::<Vec<_>>(), (0..12).filter(facing).collect::<Vec<_>>());
    let window = figures[1].window;
    let middle = decoded(&png(&far, WIDTH).unwrap()).get_pixel(window.left + window.width / 2, height / 2).0;
    assert!(middle.iter().all(|x| x.abs_diff(middle[0]) <= 1), "grey: {middle:?}");
}

#[test]
fn doubt_is_seen_as_grey() {
    let (mesh, sketch) = (cube(), square_on(&cube()));
    let unsure = Matched { confidence: vec![0.1; 4], ..sketch.pair(&mesh) };
    let is_grey = |colour: &Colour| {
        let [_, a, b] = colour.oklab();
        a.hypot(b) < 1e-3
    };
    let (sketch_colours, mesh_colours) = scene::colours(&unsure);
    assert!(sketch_colours.iter().chain(&mesh_colours).all(is_grey));
    let (sure, _) = scene::colours(&sketch.pair(&mesh));
    assert!(!sure.iter().any(is_grey) && difference(sure[0], sure[2]) > 0.2);
}

#[test]
fn the_drawing_has_the_triangles_in_sight() {
    let (mesh, sketch) = (cube(), square_on(&cube()));
    let text = svg(&sketch.pair(&mesh), WIDTH).unwrap();
    let document = usvg::roxmltree::Document::parse(&text).unwrap();
    // Two of the sketch, two of the mesh's front, and two sides of two seen from the right.
    assert_eq!(document.descendants().filter(|node| node.attribute("color").is_some()).count(), 2 + 2 + 4);
    let tree = usvg::Tree::from_str(&text, &usvg::Options::default()).unwrap();
    assert_eq!(tree.size().width(), WIDTH as f32);
}

#[test]
fn a_fine_mesh_is_embedded_as_a_picture() {
    let mesh = sphere(200, 400);
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let sketch = Sketch::new(TriangleMesh::new(corners.to_vec(), vec![[0, 1, 2]]).unwrap(), YAxis::Up).unwrap();
    let pair = Matched::new(&sketch, &mesh, [(0, 1.0), (40, 1.0), (80, 1.0)], None).unwrap();
    let text = svg(&pair, WIDTH).unwrap();
    assert!(text.len() < 2_000_000, "{}", text.len());
    let document = usvg::roxmltree::Document::parse(&text).unwrap();
    let images = document.descendants().filter(|node| node.has_tag_name("image")).count();
    assert_eq!((images, text.matches("<path color").count()), (2, 1));
}

#[test]
fn the_same_match_gives_the_same_bytes() {
    let (mesh, sketch) = (cube(), square_on(&cube()));
    let pair = sketch.pair(&mesh);
    assert_eq!(png(&pair, WIDTH).unwrap(), png(&pair, WIDTH).unwrap());
    assert_eq!(svg(&pair, WIDTH).unwrap(), svg(&pair, WIDTH).unwrap());
    let file = mesh.clone().into();
    assert_eq!(glb(&pair, &file).unwrap(), glb(&pair, &file).unwrap());
}

#[test]
fn a_picture_is_as_wide_as_asked() {
    let (mesh, sketch) = (cube(), square_on(&cube()));
    for width in [*WIDTHS.start(), 800, *WIDTHS.end()] {
        let match_picture = decoded(&png(&sketch.pair(&mesh), width).unwrap());
        assert!(match_picture.width() == width && match_picture.height() <= width * 2 / 5);
        let mesh_picture = decoded(&mesh_png(&mesh, width).unwrap());
        assert!(mesh_picture.width() == width && mesh_picture.height() <= width);
        let shares = covered(&mesh_picture, mesh_picture.height() / 2, 0..width).len() as f64 / f64::from(width);
        assert!(shares > 0.5, "{shares}");
    }
}

#[test]
fn a_mesh_alone_shows_three_sides_of_a_cube() {
    let text = mesh_svg(&cube(), 400).unwrap();
    assert_eq!(text.matches("<path color").count(), 6);
}

#[test]
fn points_of_other_shapes_are_refused() {
    let (mesh, sketch) = (cube(), square_on(&cube()));
    let matched = |points: Vec<(u32, f64)>| Matched::new(&sketch.sketch, &mesh, points, None).map(|_| ());
    assert_eq!(matched(vec![(0, 1.0); 4]), Ok(()));
    assert_eq!(matched(vec![(0, 1.0); 3]), Err(Unfit));
    assert_eq!(matched(vec![(8, 1.0); 4]), Err(Unfit));
}

#[test]
fn shapes_of_any_size_can_be_seen() {
    let square = square_on(&cube());
    for scale in [1e-49, 1e-20, 1e20, 1e49] {
        let positions = cube().positions().iter().map(|p| p.map(|x| x * scale)).collect();
        let mesh = TriangleMesh::new(positions, cube().triangles().to_vec()).unwrap();
        for view in [None, Some(Frame::looking_from([0.0, 0.0, 1.0]))] {
            let picture = decoded(&png(&Matched { view, ..square.pair(&mesh) }, WIDTH).unwrap());
            assert!(covered(&picture, picture.height() / 2, 0..WIDTH).len() > 500, "{scale}");
        }
    }
}
