//! What a viewer sees of an upload.

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

/// Room round a canvas that has no ground of its own, in pixels.
const ROOM: usize = 16;

/// An upload as pixels, and where they lie in it.
#[derive(Clone, Debug)]
pub struct Canvas {
    pub width: usize,
    pub height: usize,
    /// Red, green, blue and opacity, row by row, the colours not multiplied by the opacity.
    pub pixels: Vec<[u8; 4]>,
    /// The upper left corner, in the coordinates of the upload.
    pub origin: [f64; 2],
    /// Width and height of a pixel, in the coordinates of the upload.
    pub pixel: [f64; 2],
}

impl Canvas {
    /// The canvas with room round it where it has no ground of its own: where a corner shows the page.
    pub fn with_room(self) -> Canvas {
        let (width, height, room) = (self.width, self.height, ROOM);
        let corners = [0, width - 1, (height - 1) * width, height * width - 1];
        if corners.iter().all(|&corner| self.pixels[corner][3] == 255) {
            return self;
        }
        let [wider, higher] = [width + 2 * room, height + 2 * room];
        let mut pixels = vec![[0; 4]; wider * higher];
        for (y, row) in self.pixels.chunks_exact(width).enumerate() {
            pixels[(y + room) * wider + room..][..width].copy_from_slice(row);
        }
        let origin = [0, 1].map(|i| self.origin[i] - room as f64 * self.pixel[i]);
        Canvas { width: wider, height: higher, pixels, origin, pixel: self.pixel }
    }

    /// A point in pixels in the coordinates of the upload.
    pub fn upload_point(&self, point: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|i| self.origin[i] + self.pixel[i] * point[i])
    }

    /// The colours as they are seen on a page: a white one, or a dark one where most of what is painted is white itself.
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
        self.pixels.iter().map(|&[r, g, b, a]| [r, g, b].map(|value| mixed(value, u32::from(a)))).collect()
    }
}
