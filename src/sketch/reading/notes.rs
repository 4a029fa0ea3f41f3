//! What was mended or left out on the way to a figure, in words and with its place.

use super::canvas::Canvas;
use super::{BORDER_ROOM, FRAME, Gap, Reading};
use crate::raster::PixelBox;
use crate::raster::bitmap::Bitmap;
use crate::raster::enclosed::parts;
use crate::raster::neighbourhood::dilated;
use crate::raster::pieces::Pieces;
use crate::sketch::refusal::{Warning, WarningCode};

/// Ink that is left out is named where it takes this part of the figure's area, or reaches so far in parts of its size.
const NAMED_AREA: f64 = 0.01;
const NAMED_SIDE: f64 = 0.03;

/// Most gaps named one by one; a hatched figure has a hundred.
const MOST_GAPS: usize = 12;

/// Most pieces left out that are named one by one, largest first; the others are named together.
const MOST_LEFT_OUT: usize = 40;

/// So few pixels of a figure on the border are no cut.
const LEAST_CUT: usize = 6;

/// A figure runs over the border where it is this part as wide there as before it, and where that is looked at, in
/// multiples of the way to it.
const AS_WIDE: f64 = 0.8;
const BORDER_WIDTHS: f64 = 2.0;

/// Pixels beside a figure that are the softness of its edge.
const SOFT_EDGE: f64 = 3.0;

/// A point of a framed picture in the coordinates of the upload.
pub(super) fn upload_point(canvas: &Canvas, point: [f64; 2]) -> [f64; 2] {
    canvas.upload_point(point.map(|x| x - FRAME as f64))
}

/// A box of a framed picture in the coordinates of the upload.
pub(super) fn upload_box(canvas: &Canvas, bounds: PixelBox) -> [[f64; 2]; 2] {
    let [a, b] = [bounds.low, bounds.high].map(|corner| upload_point(canvas, corner.map(|x| x as f64)));
    [[0, 1].map(|i| a[i].min(b[i])), [0, 1].map(|i| a[i].max(b[i]))]
}

pub(super) fn warnings(reading: &Reading, canvas: &Canvas, figure: usize) -> Vec<Warning> {
    let own = &reading.figures[figure];
    let placed = |code, detail: &str, bounds: PixelBox| Warning::new(code, detail).within(upload_box(canvas, bounds));
    let boxed = |code, detail: &str, area: &Bitmap| PixelBox::of(area).map(|bounds| placed(code, detail, bounds));
    let unframed =
        |bounds: PixelBox| PixelBox { low: bounds.low.map(|x| x + FRAME), high: bounds.high.map(|x| x + FRAME) };
    let mut warnings = Vec::new();
    for &sheet in &reading.sheets {
        let detail = "a frame or a sheet was taken for what the figure is drawn on";
        warnings.push(placed(WarningCode::Background, detail, unframed(sheet)));
    }
    if let Some(bounds) = reading.patterned {
        let detail = "lines that run all over the paper were taken for its own";
        warnings.push(placed(WarningCode::Background, detail, unframed(bounds)));
    }
    let near = dilated(&own.area, reading.rim + SOFT_EDGE);
    let touches = |[x, y]: [f64; 2]| near.get((x as usize).min(near.width() - 1), (y as usize).min(near.height() - 1));
    let mut gaps: Vec<&Gap> = reading.gaps.iter().filter(|gap| touches(gap.place)).collect();
    gaps.sort_by(|a, b| b.width.total_cmp(&a.width));
    for (k, gap) in gaps.iter().enumerate().take(MOST_GAPS) {
        let width = canvas.upload_length(gap.width);
        let more = gaps.len().saturating_sub(MOST_GAPS);
        let detail = match more {
            1.. if k + 1 == MOST_GAPS => {
                format!("gaps of {width:.1} and less in the line were closed, here and in {more} places")
            }
            _ => format!("a gap of {width:.1} in the line was closed"),
        };
        warnings.push(Warning::new(WarningCode::ClosedGap, detail).at(upload_point(canvas, gap.place)));
    }
    for neck in &own.necks {
        warnings.extend(boxed(WarningCode::JoinedParts, "parts that lie apart were joined here", neck));
    }
    for limb in parts(&reading.limbs.and(&own.area), 1) {
        let detail = "a line that encloses nothing was taken for a limb of some width";
        warnings.extend(boxed(WarningCode::LineAsLimb, detail, &limb));
    }
    for cut in cuts(reading, &own.area) {
        warnings.push(placed(WarningCode::CutByBorder, "the figure runs over the border and ends there", cut));
    }
    let mut rest = reading.ink.without(&near);
    for (_, other) in reading.figures.iter().enumerate().filter(|&(k, _)| k != figure) {
        rest = rest.without(&dilated(&other.area, reading.rim + SOFT_EDGE));
        warnings.extend(boxed(WarningCode::OtherFigure, "another figure was left out", &other.area));
    }
    let side = PixelBox::of(&own.area).map_or(0, PixelBox::side) as f64;
    let pieces = Pieces::of(&rest, false);
    let mut left_out: Vec<(usize, PixelBox)> = pieces.sizes.iter().copied().zip(pieces.boxes()).collect();
    left_out.retain(|&(size, bounds)| {
        size as f64 > NAMED_AREA * own.area.area() as f64 || bounds.side() as f64 > NAMED_SIDE * side
    });
    left_out.sort_by_key(|&(size, _)| std::cmp::Reverse(size));
    let further = left_out.split_off(left_out.len().min(MOST_LEFT_OUT));
    let named = left_out.into_iter().map(|(_, bounds)| bounds);
    warnings.extend(named.map(|bounds| placed(WarningCode::LeftOut, "this was left out of the figure", bounds)));
    if let Some(bounds) = further.iter().map(|&(_, bounds)| bounds).reduce(PixelBox::with) {
        let detail = format!("{} further pieces were left out of the figure", further.len());
        warnings.push(placed(WarningCode::LeftOut, &detail, bounds));
    }
    warnings
}

/// Where the figure is as wide at the border as shortly before it: one that only touches it grows narrower.
fn cuts(reading: &Reading, figure: &Bitmap) -> Vec<PixelBox> {
    let [border, within] = &reading.borders;
    let reach = BORDER_WIDTHS * BORDER_ROOM * border.width().max(border.height()) as f64;
    let side = |area: &Bitmap| PixelBox::of(area).map_or(0, PixelBox::side);
    let is_cut = |end: &Bitmap| {
        let before = parts(&figure.and(within).and(&dilated(end, reach)), 1).iter().map(side).max().unwrap_or(0);
        side(end) > LEAST_CUT && side(end) as f64 >= AS_WIDE * before as f64
    };
    let ends = parts(&figure.and(&dilated(border, 1.0 + reading.rim)), 1);
    ends.iter().filter(|end| is_cut(end)).filter_map(PixelBox::of).collect()
}
