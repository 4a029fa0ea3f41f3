//! What lines enclose.

use super::Gap;
use super::border::straight_over;
use crate::raster::PixelBox;
use crate::raster::bitmap::Bitmap;
use crate::raster::enclosed::{filled, parts};
use crate::raster::neighbourhood::{dilated, eroded, opened, rim};

/// Width of the widest pen beside filled areas, in parts of the drawing's size.
const WIDEST_PEN: f64 = 0.055;

/// Width of the widest pen of a drawing that is lines only: icons have such.
const WIDEST_LINE: f64 = 0.13;

/// Lines are even where no more than this share of them is thicker than 1.3 times their mean width; so is a drawing of lines only.
const UNEVEN: f64 = 0.25;

/// A hole is one, and no inside of a line, where this share of its rim at least is thicker than any pen.
const SOLID_RIM: f64 = 0.85;

/// And it takes no more than this share of what it is in: what is larger is the inside of a very wide line.
const LARGEST_HOLE: f64 = 0.3;

/// Or where no more than this share of the ink is thin, and what is thin about the hole is of uneven width, as a limb is: such
/// a hole is no larger part of the figure than [`LIMB_HOLE`].
const FILLED: f64 = 0.25;
const LIMB_HOLE: f64 = 0.1;

/// Lines are darker than the fills where no more than this share of the fills is as dark; and what is thin beside a hole is
/// such a line where this share of it is.
const DARK_FILLS: f64 = 0.6;
const DARK_LINE: f64 = 0.5;

/// A limb between two such lines is more than this many times as wide as they are.
const LIMB_WIDTH: f64 = 3.0;

/// Holes of a smaller part of the figure than this are eyes and the like.
const SMALL_HOLE: f64 = 0.005;

/// Round ones are up to this part.
const ROUND_HOLE: f64 = 0.025;

/// Share of the disc over its longer side that a round hole takes.
const ROUND: f64 = 0.8;

/// And those of rings, a head that is drawn as one on a body that is filled: so far from the hole, in parts of the drawing's
/// size, all but this share of the way round it is outside.
const RINGS: [f64; 4] = [0.03, 0.05, 0.08, 0.12];
const HELD: f64 = 0.25;

/// Gaps that are closed, narrowest first, in parts of the drawing's size.
const GAPS: [f64; 8] = [0.01, 0.02, 0.03, 0.045, 0.06, 0.08, 0.1, 0.12];

/// Gaps that are too wide to be closed, though one sees that a line was meant to be.
const WIDE_GAPS: [f64; 2] = [0.15, 0.18];

/// Share of the ink that may enclose nothing: a tail, whiskers.
const LOOSE: f64 = 0.04;

/// What encloses nothing is a line where it is so many times as long as the pen is wide.
const LINE: f64 = 6.0;

/// Half the distance over which dashes are one line, in widths of the pen.
const DASHES: f64 = 1.2;

/// Share of a drawing's ink that is thin from which on it is a drawing of lines.
const LINES: f64 = 0.5;

/// Share of the rim of an area along which there is a line where the area was drawn by its outline.
const OUTLINED: f64 = 0.7;

/// And what lies deeper inside has no more than this share of the line's darkness: it is not all of a dark texture.
const DARK_INSIDE: f64 = 0.4;

/// Gaps that are closed in what is as narrow itself.
const NARROW_GAP: f64 = 0.045;

/// Share of a drawing's ink that encloses nothing from which on it is not the drawing of an outline.
const STICKS: f64 = 0.5;

/// Share of the line round an area that encloses nothing else from which on the line is there for this area.
const NEW_LINE: f64 = 0.25;

/// Share of it that lies beside nothing thick up to which what was closed is a place between legs, once the legs are.
const NEEDLESS: f64 = 0.02;

/// Pockets that are looked at again, the largest ones.
const MOST_POCKETS: usize = 8;

/// Share of the ink that encloses nothing where all but a wide gap is closed.
const STILL_LOOSE: f64 = 0.25;

/// Width of a limb that is drawn as a line, in parts of the drawing's size.
const LIMB: f64 = 0.035;

/// The areas that a drawing shows.
pub(super) struct Body {
    /// What is covered, limbs that are lines made wider.
    pub area: Bitmap,
    /// Gaps that were closed.
    pub gaps: Vec<Gap>,
    /// Lines that enclose nothing and were made limbs.
    pub limbs: Bitmap,
    /// How much of the line round the figure lies outside of its outline, in pixels.
    pub rim: f64,
}

/// What is enclosed when a gap is closed.
struct Pocket {
    area: Bitmap,
    gap: Gap,
}

/// The ink of a drawing, its size in pixels, and what in it is line.
struct Lines<'a> {
    ink: &'a Bitmap,
    size: f64,
    /// The ink with all that it goes round, and what lies outside of that, with its rim.
    whole: Bitmap,
    outside: Bitmap,
    /// Ink that is thin, and what of it is darker than the fills.
    thin: Bitmap,
    outlines: Bitmap,
    /// How wide thin ink is, in pixels.
    pen: f64,
}

/// What the ink shows; it is framed by as many empty pixels as the widest gap takes. `dark` is the part of it that is a
/// pen's, where fills are lighter; `border` is that of the sheet.
///
/// # Errors
/// The gap through which a line that should enclose the figure is open.
pub(super) fn body(ink: &Bitmap, dark: &Bitmap, border: &Bitmap, size: f64) -> Result<Body, Gap> {
    let lines = Lines::of(ink, dark, size);
    let (mut area, holes) = lines.with_insides();
    let mut pockets = lines.close_gaps(&mut area, &holes);
    if let Some(gap) = lines.wide_gap(&area, &holes) {
        return Err(gap);
    }
    let mut limbs = Bitmap::new(ink.width(), ink.height());
    if lines.thin.area() as f64 >= LINES * ink.area() as f64 {
        // What is left of a hand or a foot whose line is open is too narrow for the discs that found the rest.
        let (loose, radius, room) = (lines.loose(&area), 0.5 * NARROW_GAP * size, 0.25 * lines.pen);
        pockets.extend(lines.close(&mut area, &holes, &loose, radius, room));
        lines.keep_needed(&mut area, &mut pockets);
        let mut loose = lines.loose(&area);
        if loose.area() as f64 <= STICKS * ink.area() as f64 {
            let over = straight_over(&loose, border, size);
            area = area.without(&dilated(&over, 1.0));
            loose = loose.without(&over);
        }
        limbs = dilated(&loose, (0.5 * (LIMB * size - lines.pen)).max(0.0));
        // What is filled in the corners of limbs is no gap.
        let corners = dilated(&limbs, lines.pen);
        pockets.retain(|Pocket { gap, .. }| !corners.get(gap.place[0] as usize, gap.place[1] as usize));
    }
    let gaps = pockets.into_iter().map(|pocket| pocket.gap).collect();
    let rim = outlining_pen(&area.or(&holes), dark, size).map_or(0.0, |pen| 0.5 * pen);
    let area = if rim > 0.0 { to_mid_line(&area, rim) } else { area };
    Ok(Body { area: area.or(&limbs).without(&holes), gaps, limbs, rim })
}

/// An area without the outer half of the line round it, which is so wide; what is hardly wider than the line stays.
fn to_mid_line(area: &Bitmap, half_pen: f64) -> Bitmap {
    let thick = opened(area, 1.5 * half_pen + 0.5);
    let thin = opened(&area.without(&thick), 0.6 * half_pen);
    eroded(&thick, half_pen).or(&dilated(&thin, 1.2 * half_pen + 1.5).and(area))
}

/// The width of the line along the rim of an area; none where there is no line along most of it.
fn outlining_pen(area: &Bitmap, dark: &Bitmap, size: f64) -> Option<f64> {
    let thin = dark.without(&dilated(&opened(dark, 0.5 * WIDEST_PEN * size), 1.5));
    let edge = area.without(&eroded(area, 1.0));
    let lined = edge.and(&dilated(&thin, 2.0)).area() as f64;
    let is_outlined = lined >= OUTLINED * edge.area() as f64;
    let inside = eroded(area, WIDEST_PEN * size);
    let is_line = inside.and(dark).area() as f64 <= DARK_INSIDE * inside.area() as f64;
    (is_outlined && is_line).then(|| mean_width(&thin))
}

impl<'a> Lines<'a> {
    fn of(ink: &'a Bitmap, dark: &Bitmap, size: f64) -> Lines<'a> {
        let whole = filled(ink);
        let outside = dilated(&whole.complement(), 2.0);
        let width = mean_width(ink);
        if width <= WIDEST_LINE * size && is_even(ink) {
            let outlines = Bitmap::new(ink.width(), ink.height());
            return Lines { ink, size, whole, outside, thin: ink.clone(), outlines, pen: width };
        }
        let solid = dilated(&opened(ink, 0.5 * WIDEST_PEN * size), 1.5);
        let thin = ink.without(&solid);
        let fills = ink.and(&solid);
        let are_darker = fills.and(dark).area() as f64 <= DARK_FILLS * fills.area() as f64;
        let outlines = if are_darker { thin.and(dark) } else { Bitmap::new(ink.width(), ink.height()) };
        Lines { pen: mean_width(&thin), ink, size, whole, outside, thin, outlines }
    }

    /// The ink with what it encloses, and its true holes.
    fn with_insides(&self) -> (Bitmap, Bitmap) {
        let whole = &self.whole;
        let least = SMALL_HOLE * whole.area() as f64;
        let mut true_holes = Bitmap::new(whole.width(), whole.height());
        for hole in parts(&whole.without(self.ink), least as usize) {
            let share = hole.area() as f64 / whole.area() as f64;
            let is_filled = is_round(&hole) && (share <= ROUND_HOLE || self.is_ringed(&hole));
            if !is_filled
                && (share <= LARGEST_HOLE && self.is_in_solid(&hole)
                    || share <= LIMB_HOLE && self.limbs_before(&hole).is_some_and(|limbs| !self.is_outline(&limbs)))
            {
                true_holes = true_holes.or(&hole);
            }
        }
        (whole.without(&true_holes), true_holes)
    }

    /// Whether a line goes round a hole that lies beside nothing thicker, but for what holds it.
    fn is_ringed(&self, hole: &Bitmap) -> bool {
        RINGS.iter().any(|ring| {
            let reached = dilated(hole, ring * self.size);
            let way = dilated(&reached, 1.0).without(&reached);
            way.and(&self.whole).area() as f64 <= HELD * way.area() as f64
        })
    }

    fn is_in_solid(&self, hole: &Bitmap) -> bool {
        let rim = dilated(hole, 2.0).and(self.ink);
        rim.without(&self.thin).area() as f64 >= SOLID_RIM * rim.area() as f64
    }

    /// What is thin between a hole or a bay and what is outside, where that is no even line of a pen.
    fn limbs_before(&self, hole: &Bitmap) -> Option<Bitmap> {
        if self.thin.area() as f64 > FILLED * self.ink.area() as f64 {
            return None;
        }
        let between = parts(&self.thin.and(&dilated(hole, WIDEST_PEN * self.size)), 1);
        let limbs = between.iter().filter(|part| part.and(&self.outside).area() > 0);
        let limbs = limbs.fold(Bitmap::new(hole.width(), hole.height()), |all, limb| all.or(limb));
        (!is_even(&limbs)).then_some(limbs)
    }

    /// Whether what is thin beside a hole is a line that is darker than the fills, and no limb between two.
    fn is_outline(&self, thin: &Bitmap) -> bool {
        let lines = thin.and(&self.outlines);
        lines.area() as f64 >= DARK_LINE * thin.area() as f64 && mean_width(thin) <= LIMB_WIDTH * mean_width(&lines)
    }

    /// Thin ink that is not beside an area thicker than a line.
    fn loose(&self, area: &Bitmap) -> Bitmap {
        let loose = self.thin.without(&dilated(&self.thick(area), self.pen + 1.0));
        let least = LINE * self.pen * self.pen;
        let mut long = Bitmap::new(loose.width(), loose.height());
        for line in parts(&dilated(&loose, DASHES * self.pen), least as usize) {
            let line = line.and(&loose);
            if line.area() as f64 >= least {
                long = long.or(&line);
            }
        }
        long
    }

    /// Adds to the area what is enclosed when gaps are closed, narrow ones first, until little of the line is loose.
    fn close_gaps(&self, area: &mut Bitmap, holes: &Bitmap) -> Vec<Pocket> {
        // A line beside fills may be little of the ink and yet enclose much: narrow gaps of it are closed all the same.
        let is_little = |loose: &Bitmap, gap: f64| {
            let drawn = if gap <= NARROW_GAP { &self.thin } else { self.ink };
            loose.area() as f64 <= LOOSE * drawn.area() as f64
        };
        let mut loose = self.loose(area);
        let mut pockets = Vec::new();
        let widest = 0.5 * WIDE_GAPS[1] * self.size;
        if is_little(&loose, 0.0) || self.pockets(&area.or(holes), &loose, widest, self.room(0.0)).is_empty() {
            return pockets;
        }
        for gap in GAPS {
            if is_little(&loose, gap) {
                break;
            }
            let radius = 0.5 * gap * self.size;
            pockets.extend(self.close(area, holes, &loose, radius, self.room(radius)));
            loose = self.loose(area);
        }
        pockets
    }

    /// Adds the pockets of a radius to the area.
    fn close(&self, area: &mut Bitmap, holes: &Bitmap, loose: &Bitmap, radius: f64, room: f64) -> Vec<Pocket> {
        let pockets = self.pockets(&area.or(holes), loose, radius, room);
        *area = pockets.iter().fold(area.clone(), |area, pocket| area.or(&pocket.area));
        pockets
    }

    /// Takes away again what is between legs, of the largest pockets the smaller ones first.
    fn keep_needed(&self, area: &mut Bitmap, pockets: &mut Vec<Pocket>) {
        pockets.sort_by_key(|pocket| std::cmp::Reverse(pocket.area.area()));
        for k in (1..pockets.len().min(MOST_POCKETS)).rev() {
            let without = area.without(&pockets[k].area);
            if self.is_beside(&pockets[k].area, &without) {
                *area = without;
                pockets.remove(k);
            }
        }
    }

    /// Whether the line round a pocket is there for one thick piece of the area that lies beside it.
    fn is_beside(&self, pocket: &Bitmap, area: &Bitmap) -> bool {
        let line = dilated(pocket, 2.0).and(&self.thin);
        let thick = parts(&self.thick(area), 1);
        let near = dilated(&line, self.pen + 1.0);
        let beside: Vec<&Bitmap> = thick.iter().filter(|piece| piece.and(&near).area() > 0).collect();
        let [only] = beside[..] else { return false };
        line.without(&dilated(only, self.pen + 1.0)).area() as f64 <= NEEDLESS * line.area() as f64
    }

    /// What of an area is thicker than a line.
    fn thick(&self, area: &Bitmap) -> Bitmap {
        opened(area, 0.75 * self.pen + 0.5)
    }

    /// The gap through which a line is open that encloses the figure but for it.
    fn wide_gap(&self, area: &Bitmap, holes: &Bitmap) -> Option<Gap> {
        let loose = self.loose(area);
        let are_limbs = self.pen > WIDEST_PEN * self.size;
        if are_limbs || loose.area() as f64 <= STICKS * self.ink.area() as f64 {
            return None;
        }
        WIDE_GAPS.into_iter().find_map(|gap| {
            let radius = 0.5 * gap * self.size;
            let pockets = self.pockets(&area.or(holes), &loose, radius, self.room(radius));
            let enclosed = pockets.iter().fold(area.clone(), |area, pocket| area.or(&pocket.area));
            let is_closed = self.loose(&enclosed).area() as f64 <= STILL_LOOSE * self.ink.area() as f64;
            pockets.first().filter(|_| is_closed).map(|pocket| pocket.gap)
        })
    }

    /// What a pocket has room for, if not just the disc that closes gaps fills a corner there.
    fn room(&self, radius: f64) -> f64 {
        (0.75 * self.pen + 0.5).max(1.05 * radius)
    }

    /// What would be enclosed were gaps of up to twice `radius` closed, where the line round it is there for that: the
    /// areas into which a disc of radius `room` goes, and their gaps.
    fn pockets(&self, area: &Bitmap, loose: &Bitmap, radius: f64, room: f64) -> Vec<Pocket> {
        let sealed = eroded(&filled(&dilated(area, radius)), radius).or(area);
        let largest_bay = LARGEST_HOLE * self.whole.area() as f64;
        let near_loose = dilated(loose, 2.0);
        let least = (self.pen * self.pen).max(4.0) as usize;
        let mut pockets = Vec::new();
        for pocket in parts(&sealed.without(area), least) {
            let is_bay = pocket.area() as f64 <= largest_bay && self.limbs_before(&pocket).is_some();
            if is_bay || eroded(&pocket, room).area() == 0 {
                continue;
            }
            let line = dilated(&pocket, 2.0).and(&self.thin);
            if line.and(&near_loose).area() as f64 >= NEW_LINE * line.area() as f64 {
                let gap = gap(&pocket, area);
                pockets.push(Pocket { area: pocket, gap: Gap { width: gap.width.min(2.0 * radius), ..gap } });
            }
        }
        pockets
    }
}

/// The width of ink that is lines, in pixels.
fn mean_width(ink: &Bitmap) -> f64 {
    2.0 * ink.area() as f64 / rim(ink).max(1) as f64
}

/// Whether ink has one width, as a pen leaves it.
fn is_even(ink: &Bitmap) -> bool {
    opened(ink, 0.65 * mean_width(ink)).area() as f64 <= UNEVEN * ink.area() as f64
}

fn is_round(hole: &Bitmap) -> bool {
    let side = PixelBox::of(hole).map_or(0, PixelBox::side) as f64;
    hole.area() as f64 >= ROUND * std::f64::consts::FRAC_PI_4 * side * side
}

/// Where a pocket would be open: the longest piece of its rim along which there is no ink.
fn gap(pocket: &Bitmap, area: &Bitmap) -> Gap {
    let sealed = area.or(pocket);
    let open = sealed.without(&eroded(&sealed, 1.0)).without(&dilated(area, 1.0)).and(pocket);
    let longest = parts(&open, 1).into_iter().next();
    let bounds = longest.as_ref().and_then(PixelBox::of).or_else(|| PixelBox::of(pocket));
    bounds.map_or(Gap { place: [0.0; 2], width: 0.0 }, |bounds| Gap {
        place: bounds.centre(),
        width: bounds.side() as f64,
    })
}
