//! The sheet a figure is drawn on: the picture, or a paper, a window, a frame in it.

use std::f64::consts::FRAC_PI_4;

use super::hull::Hull;
use crate::raster::PixelBox;
use crate::raster::bitmap::Bitmap;
use crate::raster::enclosed::{filled, parts};
use crate::raster::neighbourhood::{dilated, eroded};

/// Least share of a sheet that a sheet on it takes.
const LEAST_SHARE: f64 = 0.2;

/// A sheet of four sides takes this share of its bounding box, where no quadrilateral takes enough of it.
const OF_BOX: f64 = 0.95;

/// How far the share that a disc takes of its bounding box is from π / 4.
const OFF_ROUND: f64 = 0.015;

/// The longer and the shorter side of a figure on a disc, in parts of the disc's, and the share of the disc that it takes;
/// eyes and a mouth take less.
const OF_DISC_SIDE: f64 = 0.5;
const OF_DISC_WIDTH: f64 = 0.3;
const OF_DISC: f64 = 0.08;

/// A sheet of any other shape takes this share of its hull, and what is drawn on it no more than this share of its own: a
/// patch of colour behind an animal, and no animal with a patch on its back.
const OF_BLOB_HULL: f64 = 0.88;
const SLENDER: f64 = 0.75;

/// How far the parts of a figure on a disc lie apart at most, in parts of the disc's side.
const OF_DISC_GAP: f64 = 0.04;

/// Share of its outline along which a sheet is seen to end.
const DRAWN_ROUND: f64 = 0.8;

/// What is cut off the edge of a sheet that lies on another, in parts of its side: edges are not sharp. Of a frame more is,
/// up to its inner edge.
const EDGE: f64 = 0.015;
const WIDEST_FRAME: f64 = 0.06;

/// A paper of which the desk shows at some sides is ground that takes this share of its hull, without this share of the
/// picture, and carries what is drawn over this part of its side.
const OF_HULL: f64 = 0.97;
const BESIDE: f64 = 0.01;
const OF_PAPER_SIDE: f64 = 0.1;

/// What is cut off the edge of such a paper, in parts of its side: ground is seen within its edge only, as far as that is straight.
const PAPER_EDGE: f64 = 0.0075;

/// Where a figure is looked for.
#[derive(Clone, Debug)]
pub(super) struct Sheet {
    pub area: Bitmap,
    /// The box at whose sides it ends: that about its area, but for room that was made beside a picture.
    pub sides: PixelBox,
}

/// A sheet on another.
pub(super) struct Upon {
    pub sheet: Sheet,
    pub bounds: PixelBox,
    form: Form,
}

#[derive(Clone, Copy)]
enum Form {
    FourSided,
    /// A disc may be a figure itself, with a face on it.
    Round,
    /// A patch of another shape, as round figures have on them, too.
    Blob,
    /// A paper that runs over the border of the picture, seen as its ground.
    Ground,
}

impl Upon {
    /// Whether what is drawn here is a figure on a sheet, and not the features of a round figure or dust.
    pub fn carries(&self, ink: &Bitmap) -> bool {
        match self.form {
            Form::FourSided => true,
            Form::Round => self.figure_on_disc(ink).is_some(),
            Form::Blob => self
                .figure_on_disc(ink)
                .is_some_and(|figure| figure.area() as f64 <= SLENDER * Hull::of(&figure).area.area() as f64),
            Form::Ground => {
                PixelBox::of(ink).is_some_and(|drawn| drawn.side() as f64 >= OF_PAPER_SIDE * self.bounds.side() as f64)
            }
        }
    }

    /// What is drawn on a disc, where that is a figure on it.
    fn figure_on_disc(&self, ink: &Bitmap) -> Option<Bitmap> {
        let whole = filled(ink);
        let side = self.bounds.side() as f64;
        let border = self.sheet.border(1.0);
        let is_figure = |part: &Bitmap| {
            PixelBox::of(part).is_some_and(|own| {
                own.side() as f64 >= OF_DISC_SIDE * side
                    && own.width().min(own.height()) as f64 >= OF_DISC_WIDTH * side
                    && part.area() as f64 >= OF_DISC * self.sheet.area.area() as f64
                    && part.and(&border).area() == 0
            })
        };
        let together = || {
            let all = parts(&dilated(&whole, 0.5 * OF_DISC_GAP * side), 1).into_iter();
            all.map(|all| all.and(&whole)).max_by_key(Bitmap::area)
        };
        let largest = parts(&whole, 1).into_iter().next()?;
        if is_figure(&largest) { Some(largest) } else { together().filter(is_figure) }
    }
}

impl Sheet {
    /// The whole of a picture.
    pub fn whole(width: usize, height: usize) -> Sheet {
        let mut area = Bitmap::new(width, height);
        (0..height).for_each(|y| area.fill(y, 0, width, true));
        Sheet { area, sides: PixelBox { low: [0; 2], high: [width, height] } }
    }

    /// The sheet of an area with a pixel at least.
    fn of(area: Bitmap) -> Option<Sheet> {
        PixelBox::of(&area).map(|sides| Sheet { area, sides })
    }

    /// Its pixels within so many of its border.
    pub fn border(&self, width: f64) -> Bitmap {
        self.area.without(&eroded(&self.area.framed(2), width).cropped(2))
    }

    /// The sheet that what is drawn on this one may be: of four sides, round or a patch of colour, large, and drawn all round.
    pub fn upon(&self, ink: &Bitmap) -> Option<Upon> {
        let largest = || parts(ink, 1).into_iter().next();
        self.within(ink).or_else(|| self.within(&largest()?))
    }

    /// The sheet that one of the plates seen on this one may be: a paper of four sides, or one that runs over the border. In
    /// what was not photographed it may be a figure's own body, with a face on it.
    pub fn plate(&self, plates: &[Bitmap], is_photograph: bool) -> Option<Upon> {
        let border = self.border(1.0);
        let form = if is_photograph { Form::Ground } else { Form::Round };
        plates.iter().find_map(|plate| {
            let hull = Hull::of(plate);
            let is_paper = hull.has_four_sides() || plate.and(&border).area() > 0;
            if is_paper { self.steady(plate, &hull.area, form) } else { None }
        })
    }

    /// The sheet that one of the grounds seen on this one may be: a paper of which the desk shows at some sides only.
    pub fn paper(&self, grounds: &[Bitmap]) -> Option<Upon> {
        grounds.iter().find_map(|ground| self.steady(ground, &Hull::of(ground).area, Form::Ground))
    }

    /// The sheet that something steady may be which has this hull.
    fn steady(&self, steady: &Bitmap, hull: &Bitmap, form: Form) -> Option<Upon> {
        let (all, area) = (self.area.area() as f64, hull.area() as f64);
        let is_some = area >= LEAST_SHARE * all && area <= (1.0 - BESIDE) * all;
        if !is_some || (filled(steady).area() as f64) < OF_HULL * area {
            return None;
        }
        let bounds = PixelBox::of(hull)?;
        // Where it runs over the border of the picture nothing is cut off.
        let inner = eroded(hull, (PAPER_EDGE * bounds.side() as f64).max(2.0));
        Sheet::of(inner).map(|sheet| Upon { sheet, bounds, form })
    }

    fn within(&self, ink: &Bitmap) -> Option<Upon> {
        let bounds = PixelBox::of(ink)?;
        let hull = Hull::of(ink);
        let area = hull.area.area() as f64;
        let of_box = area / (bounds.width() * bounds.height()) as f64;
        if area < LEAST_SHARE * self.area.area() as f64 {
            return None;
        }
        let (form, shape) = if of_box >= OF_BOX || hull.has_four_sides() {
            (Form::FourSided, hull.area)
        } else if (of_box - FRAC_PI_4).abs() <= OFF_ROUND {
            (Form::Round, hull.area)
        } else if ink.area() as f64 >= OF_BLOB_HULL * area {
            (Form::Blob, filled(ink))
        } else {
            return None;
        };
        let edge = (EDGE * bounds.side() as f64).max(2.0);
        let rim = shape.without(&eroded(&shape.framed(2), 1.0).cropped(2));
        if (rim.and(&dilated(ink, edge)).area() as f64) < DRAWN_ROUND * rim.area() as f64 {
            return None;
        }
        let inner = within_frame(&shape, ink, edge, (WIDEST_FRAME * bounds.side() as f64).max(2.0));
        Sheet::of(inner).map(|sheet| Upon { sheet, bounds, form })
    }
}

/// A shape without the frame round it that is drawn, which is from `least` to `most` wide; without `least` where what is
/// drawn goes on, as a paper on a desk does.
fn within_frame(shape: &Bitmap, ink: &Bitmap, least: f64, most: f64) -> Bitmap {
    let cut = |by: f64| eroded(&shape.framed(2), by).cropped(2);
    let is_framed = |inner: &Bitmap| {
        let rim = inner.without(&eroded(&inner.framed(2), 1.0).cropped(2));
        rim.and(ink).area() as f64 >= DRAWN_ROUND * rim.area() as f64
    };
    let steps = (0..).map(|k| least + f64::from(k)).take_while(|&by| by <= most);
    steps.map(&cut).find(|inner| !is_framed(inner)).unwrap_or_else(|| cut(least))
}
