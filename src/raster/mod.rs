//! Pictures in black and white: their pieces, what lies near, what they enclose, and the lines round them; and those that
//! triangles leave, as a silhouette and as the surface in front.

pub mod bitmap;
pub mod contour;
pub mod distance;
pub mod enclosed;
pub mod neighbourhood;
pub mod pieces;
pub mod silhouette;
pub mod skeleton;
pub mod visible;

/// A box of pixels: columns and rows, the last of each not included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PixelBox {
    pub low: [usize; 2],
    pub high: [usize; 2],
}

impl PixelBox {
    /// The least box round the pixels set; none where there are none.
    pub fn of(picture: &bitmap::Bitmap) -> Option<PixelBox> {
        let mut found: Option<PixelBox> = None;
        for y in 0..picture.height() {
            for run in picture.runs(y) {
                let own = PixelBox { low: [run.start, y], high: [run.end, y + 1] };
                found = Some(found.map_or(own, |all| all.with(own)));
            }
        }
        found
    }

    /// The least box round both.
    pub fn with(self, other: PixelBox) -> PixelBox {
        PixelBox {
            low: [0, 1].map(|i| self.low[i].min(other.low[i])),
            high: [0, 1].map(|i| self.high[i].max(other.high[i])),
        }
    }

    pub fn width(self) -> usize {
        self.high[0] - self.low[0]
    }

    pub fn height(self) -> usize {
        self.high[1] - self.low[1]
    }

    /// The longer side.
    pub fn side(self) -> usize {
        self.width().max(self.height())
    }

    /// The point in the middle.
    pub fn centre(self) -> [f64; 2] {
        [0, 1].map(|i| 0.5 * (self.low[i] + self.high[i]) as f64)
    }
}
