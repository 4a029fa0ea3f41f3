//! Writing in pictures made of pixels; what is made of lines leaves it to whoever shows it.

use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

/// Height of a line of writing in pixels, and the size of letters in SVG that is like it.
pub const LINE: u32 = 16;
pub const SIZE: u32 = 14;

/// Where a line of writing stands from its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    Start,
    Middle,
    End,
}

/// A line of writing, its place at half its height.
#[derive(Clone, Debug, PartialEq)]
pub struct Writing {
    pub at: [f64; 2],
    pub anchor: Anchor,
    pub text: String,
}

/// Width of a line of writing in pixels.
pub fn width(text: &str) -> u32 {
    let letter = get_raster_width(FontWeight::Regular, RasterHeight::Size16);
    (text.chars().count() * letter) as u32
}

impl Writing {
    /// As an element of SVG.
    pub fn svg(&self) -> String {
        let anchor = match self.anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let [x, y] = self.at;
        let text = self.text.replace('&', "&amp;").replace('<', "&lt;");
        // A third of their size is about half the height of letters.
        let baseline = y + f64::from(SIZE) / 3.0;
        format!("<text x=\"{x:.1}\" y=\"{baseline:.1}\" text-anchor=\"{anchor}\">{text}</text>\n")
    }

    /// Writes into the pixels of a picture of this width, by rows, in black; letters that there are not are left out.
    pub fn write(&self, pixels: &mut [[u8; 3]], picture_width: u32) {
        let length = f64::from(width(&self.text));
        let left = match self.anchor {
            Anchor::Start => self.at[0],
            Anchor::Middle => self.at[0] - 0.5 * length,
            Anchor::End => self.at[0] - length,
        };
        let (left, top) =
            (left.round().max(0.0) as usize, (self.at[1] - 0.5 * f64::from(LINE)).round().max(0.0) as usize);
        let (picture_width, letter) = (picture_width as usize, width(" ") as usize);
        for (i, character) in self.text.chars().enumerate() {
            let Some(raster) = get_raster(character, FontWeight::Regular, RasterHeight::Size16) else { continue };
            for (y, row) in raster.rows().enumerate() {
                for (x, ink) in row.iter().enumerate() {
                    let x = left + i * letter + x;
                    let at = (top + y) * picture_width + x;
                    let Some(pixel) = pixels.get_mut(at).filter(|_| x < picture_width) else { continue };
                    *pixel = pixel.map(|light| (u16::from(light) * u16::from(255 - ink) / 255) as u8);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn writing_stands_at_its_anchor() {
        for (anchor, from, to) in [(Anchor::Start, 50, 68), (Anchor::Middle, 41, 59), (Anchor::End, 32, 50)] {
            let mut pixels = vec![[255; 3]; 100 * 40];
            Writing { at: [50.0, 20.0], anchor, text: "MM".to_owned() }.write(&mut pixels, 100);
            let dark: Vec<usize> = (0..pixels.len()).filter(|&i| pixels[i][0] < 128).collect();
            let (least, most) = (dark.iter().map(|i| i % 100).min(), dark.iter().map(|i| i % 100).max());
            let two_letters = 2 * width("M") as usize;
            assert!(least >= Some(from) && most < Some(to.max(from + two_letters)), "{anchor:?}: {least:?} {most:?}");
            assert!(dark.iter().all(|i| (12..28).contains(&(i / 100))));
        }
    }

    #[test]
    fn writing_that_does_not_fit_is_cut_off() {
        let mut pixels = vec![[255; 3]; 20 * 20];
        Writing { at: [15.0, 18.0], anchor: Anchor::Start, text: "long".to_owned() }.write(&mut pixels, 20);
        assert!(pixels.iter().any(|pixel| pixel[0] < 128));
        assert!(Writing { at: [0.0; 2], anchor: Anchor::End, text: "a<b&c".to_owned() }.svg().contains("a&lt;b&amp;c"));
    }
}
