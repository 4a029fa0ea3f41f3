//! What a drawing shows: the figure that a viewer sees in it, whatever it was drawn with and whatever form it has.
//!
//! A [`canvas::Canvas`] is looked at as people do. A [`sheet`] has a [`ground`], perhaps [`rules`] and a [`binding`]; what else
//! differs from it is [`ink`]. Thin ink is a line and stands for what it encloses ([`enclosure`]), all else for itself, but for
//! the [`floor`]; lines that run over the [`border`] end there. Parts that belong together make a figure ([`figures`]), and the
//! lines round it are its [`outline`]. Whatever was mended or left out is a [`notes::Note`].

mod binding;
mod blocks;
mod border;
pub(crate) mod canvas;
pub(crate) mod checkerboard;
mod closing;
mod colours;
mod continued;
mod edge;
mod enclosure;
mod faint;
mod figures;
mod floor;
mod ground;
mod hull;
mod ink;
mod leaks;
mod notes;
mod outline;
mod rules;
mod shadow;
mod sheet;
mod slits;
mod strokes;

use std::iter::once_with;

use canvas::Canvas;
use enclosure::Body;
use figures::Figure;
use ground::Ground;
use ink::{Drawn, Ink};
use sheet::{Sheet, Upon};

use super::Line;
use super::SeenFigure;
use super::outline::Drawing;
use super::refusal::{Fault, Refusal, Warning};
use crate::raster::PixelBox;
use crate::raster::bitmap::Bitmap;
use crate::raster::enclosed::{filled, parts};
use crate::raster::neighbourhood::dilated;

/// Empty pixels round what is drawn: more than half of the widest gap takes, which is 18 % of at most 672 pixels.
const FRAME: usize = 63;

/// Sheets that may lie on each other: a window on a desk, a picture in it, its frame.
const MOST_SHEETS: usize = 4;

/// What is drawn farther from the rest than this part of the drawing's size is looked at by itself.
const APART: f64 = 0.08;

/// What is smaller than this share of the largest of such drawings is no drawing, but a spot.
const SPOT: f64 = 0.02;

/// How far within the border it is seen whether a figure ends there or runs over it, in parts of the canvas's side.
const BORDER_ROOM: f64 = 0.02;

/// How near to the border a line runs over it, in pixels.
const ON_BORDER: f64 = 3.0;

/// A figure of fewer pixels has no shape to speak of.
const SMALLEST_FIGURE: usize = 100;

/// Pieces of one drawing: so many, the largest smaller than this part of the box about all of them, and line that encloses
/// nothing to this share.
const SCRAP_FIGURES: usize = 5;
const SCRAP: f64 = 0.04;
const SCRAP_LINE: f64 = 0.5;

/// A line that was open: where, and how far, in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Gap {
    place: [f64; 2],
    width: f64,
}

/// What is seen on a canvas. All pictures have a frame of [`FRAME`] pixels round the canvas.
pub(crate) struct Reading {
    /// Largest first; at least one.
    figures: Vec<Figure>,
    /// All that is drawn, and of that what differs from the ground by much.
    ink: Bitmap,
    dark: Bitmap,
    gaps: Vec<Gap>,
    /// Lines that enclose nothing and were made limbs.
    limbs: Bitmap,
    /// How much of the lines round figures lies outside of their outlines, in pixels.
    rim: f64,
    /// The sheet, where lines all over it were taken for its own.
    patterned: Option<PixelBox>,
    /// Frames and papers that what is drawn lies on.
    sheets: Vec<PixelBox>,
    /// The outermost pixels of the sheet, and those [`BORDER_ROOM`] within.
    borders: [Bitmap; 2],
}

impl Reading {
    /// What a viewer sees on the canvas.
    ///
    /// # Errors
    /// A blank canvas; a scene without a ground; a line that stays open, with its place.
    pub fn of(canvas: &Canvas) -> Result<Reading, Refusal> {
        let colours = canvas.on_page();
        let mut sheet = Sheet { sides: canvas.own, ..Sheet::whole(canvas.width, canvas.height) };
        let mut sheets = Vec::new();
        let mut seen = Seen::of(&colours, &sheet);
        while sheets.len() < MOST_SHEETS
            && let Drawn::Ink(ink) | Drawn::Scene(ink) = &seen.drawn
            && let Some((upon, inner)) = once_with(|| sheet.upon(&ink.all))
                .chain(once_with(|| sheet.paper(&seen.grounds)))
                .chain(once_with(|| sheet.plate(&seen.plates, seen.is_photograph)))
                .flatten()
                .find_map(|upon| upon.carrying(&colours))
        {
            sheets.push(upon.bounds);
            (sheet, seen) = (upon.sheet, inner);
        }
        let ink = match seen.drawn {
            Drawn::Ink(ink) => ink,
            Drawn::Nothing => return Err(Refusal::plain(BLANK)),
            Drawn::Scene(_) => return Err(Refusal::plain(SCENE)),
        };
        let ink = ink.without_floor().closed_along(&sheet);
        let inwards = BORDER_ROOM * canvas.width.max(canvas.height) as f64;
        let border = sheet.border(1.0).framed(FRAME);
        let within = sheet.border(inwards + 1.0).without(&sheet.border(inwards)).framed(FRAME);
        let patterned = ink.patterned.then(|| PixelBox::of(&sheet.area)).flatten();
        let ink =
            Ink { all: ink.all.framed(FRAME), dark: ink.dark.framed(FRAME), aside: ink.aside.framed(FRAME), ..ink };
        let (body, size) = body(&ink, &dilated(&border, ON_BORDER)).map_err(|gap| stays_open(canvas, gap))?;
        let figures = figures::figures(&body, &ink.all, size);
        let largest = figures.first().map_or(0, |figure| figure.area.area());
        if largest < SMALLEST_FIGURE {
            let detail = format!("the largest figure has {largest} pixels; at least {SMALLEST_FIGURE} are needed");
            return Err(Refusal::plain(detail));
        }
        if is_scraps(&figures, &body.limbs) {
            return Err(Refusal::plain(SCRAPS));
        }
        Ok(Reading {
            figures,
            ink: ink.all.or(&ink.aside),
            dark: ink.dark,
            gaps: body.gaps,
            limbs: body.limbs,
            rim: body.rim,
            patterned,
            sheets,
            borders: [border, within],
        })
    }

    /// The outline of a figure, the largest being number 0, and the lines drawn within it, longest first, in the coordinates
    /// of the upload.
    ///
    /// # Errors
    /// A contour of more than `max_points` points.
    pub fn drawing(&self, canvas: &Canvas, figure: usize, max_points: usize) -> Result<(Drawing, Vec<Line>), Refusal> {
        let area = &self.figures[figure].area;
        let depth = strokes::outline_depth(area, &self.dark);
        let marked = strokes::marked(area, &self.dark, depth);
        let lines = strokes::within(area, &marked, depth);
        let drawing = outline::drawing(canvas, &slits::slit(area, &marked, &lines, depth), max_points)
            .ok_or_else(|| Refusal::plain("the figure's contour is too long: the picture is too noisy"))?;
        Ok((drawing, strokes::placed(canvas, &lines)))
    }

    /// Where the figures are and how large, largest first.
    pub fn figures(&self, canvas: &Canvas) -> Vec<SeenFigure> {
        let of_pixel = (canvas.pixel[0] * canvas.pixel[1]).abs();
        let seen = |figure: &Figure| {
            PixelBox::of(&figure.area).map(|bounds| SeenFigure {
                bounds: notes::upload_box(canvas, bounds),
                area: figure.area.area() as f64 * of_pixel,
            })
        };
        self.figures.iter().filter_map(seen).collect()
    }

    /// What was mended or left out on the way to a figure, and where.
    pub fn warnings(&self, canvas: &Canvas, figure: usize) -> Vec<Warning> {
        notes::warnings(self, canvas, figure)
    }
}

const BLANK: &str = "nothing is drawn here: all of it has about one colour";

const SCENE: &str = "this looks like a scene, not like a figure on a ground: what is drawn runs over the border nearly all \
                     round; cut the figure out, or draw its outline";

const SCRAPS: &str = "what is drawn falls into pieces, none of which is a figure: the line is too faint or has too many gaps; \
                      draw it darker, or photograph it with more light";

/// Whether the figures are but pieces of one that was drawn in a faint line: many, each small beside all of them together, and
/// the largest a line that encloses nothing.
fn is_scraps(figures: &[Figure], limbs: &Bitmap) -> bool {
    let [largest, ..] = figures else { return false };
    if figures.len() < SCRAP_FIGURES {
        return false;
    }
    let all = figures.iter().fold(largest.area.clone(), |all, figure| all.or(&figure.area));
    let extent = PixelBox::of(&all).map_or(0, |bounds| bounds.width() * bounds.height()) as f64;
    let area = largest.area.area() as f64;
    area < SCRAP * extent && largest.area.and(limbs).area() as f64 >= SCRAP_LINE * area
}

fn stays_open(canvas: &Canvas, Gap { place, width }: Gap) -> Refusal {
    let [x, y] = notes::upload_point(canvas, place);
    let width = canvas.upload_length(width);
    let detail = format!("the line stays open, with a gap of {width:.1}, so that it encloses no figure; close it");
    Refusal { faults: vec![Fault::plain(detail).at([x, y])] }
}

/// What is seen on a sheet: what is drawn there, on what grounds, and what may be papers.
struct Seen {
    drawn: Drawn,
    grounds: Vec<Bitmap>,
    plates: Vec<Bitmap>,
    /// Whether the picture has the noise of a camera.
    is_photograph: bool,
}

impl Seen {
    fn of(colours: &[[u8; 3]], sheet: &Sheet) -> Seen {
        let look = |lined: bool| {
            let ground = Ground::of(colours, sheet, lined);
            let (drawn, is_photograph) = (ink::drawn(&ground, sheet), ground.noise > 0);
            Seen { drawn, grounds: ground.pieces, plates: ground.plates, is_photograph }
        };
        match look(false) {
            Seen { drawn: Drawn::Ink(ink) | Drawn::Scene(ink), .. } if ink.patterned => look(true),
            seen => seen,
        }
    }
}

impl Upon {
    /// The sheet with what is seen on it, where that is a figure.
    fn carrying(self, colours: &[[u8; 3]]) -> Option<(Upon, Seen)> {
        let seen = Seen::of(colours, &self.sheet);
        let carries = matches!(&seen.drawn, Drawn::Ink(ink) if self.carries(&ink.all));
        carries.then_some((self, seen))
    }
}

/// What the ink shows on a sheet with this border, each drawing that lies apart looked at by itself, and the size of the
/// largest, in pixels.
fn body(ink: &Ink, border: &Bitmap) -> Result<(Body, f64), Gap> {
    let side = |area: &Bitmap| PixelBox::of(area).map_or(0, PixelBox::side) as f64;
    let nothing = Bitmap::new(ink.all.width(), ink.all.height());
    let mut whole = Body { area: nothing.clone(), gaps: Vec::new(), limbs: nothing, rim: 0.0 };
    let (mut size, mut most) = (0.0_f64, 0);
    for apart in parts(&dilated(&ink.all, 0.5 * APART * side(&ink.all)), 1) {
        let own = ink.all.and(&apart);
        most = most.max(own.area());
        if (own.area() as f64) < SPOT * most as f64 {
            whole.area = whole.area.or(&filled(&own));
            continue;
        }
        size = size.max(side(&own));
        let body = enclosure::body(&own, &ink.dark.and(&own), border, side(&own))?;
        whole.area = whole.area.or(&body.area);
        whole.limbs = whole.limbs.or(&body.limbs);
        whole.gaps.extend(body.gaps);
        whole.rim = whole.rim.max(body.rim);
    }
    Ok((whole, size))
}

#[cfg(test)]
mod tests;
