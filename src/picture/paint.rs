//! What a shape is coloured by: a function, labels, or colours themselves.

use super::colour::{Colour, diverging};
use super::surface;
use crate::mesh::file_mesh::FileMesh;

/// Lightness and chroma of the colours of regions; their hues go round by the golden ratio, so that neighbours in number
/// differ, and every other is lighter.
const LIGHTNESS: [f64; 2] = [0.58, 0.76];
const CHROMA: f64 = 0.14;
const TURN: f64 = 0.618_033_988_749_894_9;

/// Something for every vertex of a file that colours it.
#[derive(Clone, Copy, Debug)]
pub enum Paint<'a> {
    /// Red above 0 and blue below where there is both, by the largest magnitude; else from white at the least to red, or blue,
    /// at the other end. Light grey where there is no number.
    Values(&'a [f64]),
    /// A colour for each label; light grey for negative ones.
    Labels(&'a [i32]),
    /// Red, green and blue in sRGB, each in `[0, 1]`; light grey where there is none.
    Colours(&'a [Option<[f64; 3]>]),
}

impl Paint<'_> {
    /// The colours of the vertices of the sound mesh.
    pub(super) fn on(&self, mesh: &FileMesh) -> Vec<Colour> {
        let of_file = self.colours();
        mesh.origins().iter().map(|&v| of_file.get(v as usize).copied().unwrap_or_else(surface::plain)).collect()
    }

    fn colours(&self) -> Vec<Colour> {
        match self {
            Paint::Values(values) => of_values(values),
            Paint::Labels(labels) => labels.iter().map(|&label| of_label(label)).collect(),
            Paint::Colours(colours) => {
                colours.iter().map(|rgb| rgb.map_or_else(surface::plain, Colour::of_srgb)).collect()
            }
        }
    }
}

fn of_values(values: &[f64]) -> Vec<Colour> {
    let finite = || values.iter().copied().filter(|x| x.is_finite());
    let (least, most) = (finite().fold(f64::INFINITY, f64::min), finite().fold(f64::NEG_INFINITY, f64::max));
    let largest = least.abs().max(most.abs());
    let share = |x: f64| match x {
        x if least >= 0.0 => (x - least) / (most - least),
        x if most <= 0.0 => (x - most) / (most - least),
        x => x / largest,
    };
    let colour = |&x: &f64| {
        let share = share(x);
        if !x.is_finite() {
            surface::plain()
        } else if share.is_finite() {
            diverging(share)
        } else {
            Colour::WHITE
        }
    };
    values.iter().map(colour).collect()
}

fn of_label(label: i32) -> Colour {
    let Ok(number) = u32::try_from(label) else { return surface::plain() };
    Colour::of(LIGHTNESS[number as usize % 2], CHROMA, f64::from(number) * TURN)
}

#[cfg(test)]
mod tests {
    use super::super::colour::difference;
    use super::*;
    use crate::mesh::solids::sheet;

    #[test]
    fn functions_of_both_signs_are_white_at_zero_and_others_at_their_least() {
        let bytes = |colours: &[Colour]| colours.iter().map(|colour| colour.bytes()).collect::<Vec<_>>();
        let seen = |values: &[f64]| bytes(&of_values(values));
        let (red, blue) = (diverging(1.0), diverging(-1.0));
        assert_eq!(seen(&[-2.0, 0.0, 1.0]), bytes(&[blue, Colour::WHITE, diverging(0.5)]));
        assert_eq!(seen(&[3.0, 5.0, f64::NAN]), bytes(&[Colour::WHITE, red, surface::plain()]));
        assert_eq!(seen(&[-3.0, -5.0]), bytes(&[Colour::WHITE, blue]));
        assert_eq!(seen(&[4.0, 4.0]), bytes(&[Colour::WHITE; 2]));
    }

    #[test]
    fn regions_are_told_apart() {
        for a in 0..12 {
            assert!((0..a).all(|b| difference(of_label(a), of_label(b)) > 0.04), "{a}");
        }
        assert_eq!(of_label(-1), surface::plain());
    }

    #[test]
    fn colours_stay_what_they_are() {
        let mesh = FileMesh::from(sheet(1, 1));
        let colours = [Some([1.0, 0.0, 0.0]), Some([0.5; 3]), None];
        let painted = Paint::Colours(&colours).on(&mesh);
        assert_eq!(painted[0].bytes(), [255, 0, 0]);
        assert_eq!(painted[1].bytes(), [128; 3]);
        assert_eq!(painted[2..], [surface::plain(); 2]);
    }
}
