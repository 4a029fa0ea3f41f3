//! What a viewer sees of an upload.

use crate::raster::PixelBox;
use crate::raster::bitmap::Bitmap;
use crate::raster::pieces::{Pieces, Run};

/// Pixels along the longer side of a canvas at most: a tenth of one is less than hands draw to, and twice as many would take
/// three times as long to read.
pub(crate) const LONGEST_SIDE: usize = 640;

/// Opacity from which on a pixel is painted, and the least of red, green and blue of what is white, in 255ths.
const SOLID: u8 = 64;
const WHITE: u8 = 240;

/// Share of what is painted that is white where it is made for a dark page.
const ALL_WHITE: f64 = 0.8;

/// The grey of a dark page: apart from white, and from black.
const DARK_PAGE: u32 = 112;

/// Least of red, green and blue of paint that cannot be told from a white page; the share of a piece of it that is white
/// altogether where it covers what is below as an eraser does, and shaded paint is not; and the grey that is seen instead of
/// what is no cover.
const PALE: u8 = 237;
const COVER: f64 = 0.9;
const SHADED: u8 = 190;

/// Opacity from which on a pixel hides the page, in 255ths: the edges of what covers all of it are hardly softened.
const OPAQUE: u8 = 250;

/// Room round a canvas that has no ground of its own, in pixels.
const ROOM: usize = 16;

/// An upload as pixels, and where they lie in it.
#[derive(Clone, Debug)]
pub struct Canvas {
    pub width: usize,
    pub height: usize,
    /// Red, green, blue and opacity, row by row, the colours not multiplied by the opacity.
    pub pixels: Vec<[u8; 4]>,
    /// Where in it the upload lies: there may be room beside it.
    pub own: PixelBox,
    /// The sides over which the upload goes on: left and right, upper and lower.
    pub cut: [[bool; 2]; 2],
    /// The upper left corner, in the coordinates of the upload.
    pub origin: [f64; 2],
    /// Width and height of a pixel, in the coordinates of the upload: below zero where the upload shows those mirrored.
    pub pixel: [f64; 2],
}

impl Canvas {
    /// The canvas with room at its sides where it has no ground of its own there and all is seen: where both their corners show the
    /// page.
    pub fn with_room(self) -> Canvas {
        let (width, height) = (self.width, self.height);
        let shows_page = |x: usize, y: usize| self.pixels[y * width + x][3] < OPAQUE;
        let (left, right, top, bottom) = (0, width - 1, 0, height - 1);
        let room = |is_cut: bool, a: bool, b: bool| if !is_cut && a && b { ROOM } else { 0 };
        let [across, down] = self.cut;
        let [above, below] = [(top, down[0]), (bottom, down[1])]
            .map(|(y, is_cut)| room(is_cut, shows_page(left, y), shows_page(right, y)));
        let [before, behind] = [(left, across[0]), (right, across[1])]
            .map(|(x, is_cut)| room(is_cut, shows_page(x, top), shows_page(x, bottom)));
        let [wider, higher] = [before + width + behind, above + height + below];
        let mut pixels = vec![[0; 4]; wider * higher];
        for (y, row) in self.pixels.chunks_exact(width).enumerate() {
            pixels[(y + above) * wider + before..][..width].copy_from_slice(row);
        }
        let origin = [before, above].map(|room| room as f64);
        let origin = [0, 1].map(|i| self.origin[i] - origin[i] * self.pixel[i]);
        let own = PixelBox { low: [before, above], high: [before + width, above + height] };
        Canvas { width: wider, height: higher, pixels, own, origin, ..self }
    }

    /// A point in pixels in the coordinates of the upload.
    pub fn upload_point(&self, point: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|i| self.origin[i] + self.pixel[i] * point[i])
    }

    /// So many pixels as a length in the coordinates of the upload.
    pub fn upload_length(&self, pixels: f64) -> f64 {
        pixels * self.pixel[0].abs().max(self.pixel[1].abs())
    }

    /// The colour at a point in the coordinates of the upload, red, green and blue in sRGB, each in `[0, 1]`, on white; that of
    /// the nearest pixel where it lies outside.
    pub fn colour_at(&self, point: [f64; 2]) -> [f64; 3] {
        let place = |axis: usize, count: usize| {
            let place = ((point[axis] - self.origin[axis]) / self.pixel[axis]).floor();
            place.clamp(0.0, count.saturating_sub(1) as f64) as usize
        };
        let [red, green, blue, opacity] = self.pixels[place(1, self.height) * self.width + place(0, self.width)];
        let opacity = f64::from(opacity) / 255.0;
        [red, green, blue].map(|x| opacity * f64::from(x) / 255.0 + 1.0 - opacity)
    }

    /// The colours as they are seen on a page: a white one, or a dark one where most of what is painted is white itself. What
    /// is nearly as white as the page it is painted on is seen by its shade.
    pub fn on_page(&self) -> Vec<[u8; 3]> {
        let painted = self.pixels.iter().filter(|pixel| pixel[3] > SOLID);
        let (mut all, mut white) = (0, 0);
        painted.for_each(|&[r, g, b, _]| {
            all += 1;
            white += usize::from(r.min(g).min(b) >= WHITE);
        });
        let has_page = all < self.pixels.len();
        let page = if has_page && white as f64 > ALL_WHITE * all as f64 { DARK_PAGE } else { 255 };
        let mixed = |value: u8, opacity: u32| ((u32::from(value) * opacity + page * (255 - opacity) + 127) / 255) as u8;
        let mut colours: Vec<[u8; 3]> =
            self.pixels.iter().map(|&[r, g, b, a]| [r, g, b].map(|value| mixed(value, u32::from(a)))).collect();
        if has_page && page == 255 {
            self.shade(&mut colours);
        }
        colours
    }

    /// Darkens the pieces of paint that are nearly white and no covers.
    fn shade(&self, colours: &mut [[u8; 3]]) {
        let mut pale = Bitmap::new(self.width, self.height);
        for (k, &[r, g, b, a]) in self.pixels.iter().enumerate() {
            if a >= OPAQUE && r.min(g).min(b) >= PALE {
                pale.set(k % self.width, k / self.width);
            }
        }
        let pieces = Pieces::of(&pale, false);
        let of_run = |run: &Run| run.y * self.width + run.from..run.y * self.width + run.to;
        let mut white = vec![0; pieces.sizes.len()];
        for run in &pieces.runs {
            white[run.piece] += self.pixels[of_run(run)].iter().filter(|pixel| pixel[..3] == [255; 3]).count();
        }
        let is_cover = |run: &&Run| white[run.piece] as f64 >= COVER * pieces.sizes[run.piece] as f64;
        pieces.runs.iter().filter(|run| !is_cover(run)).for_each(|run| colours[of_run(run)].fill([SHADED; 3]));
    }
}
