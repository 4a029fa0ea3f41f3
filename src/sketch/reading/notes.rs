//! What was mended or left out on the way to a figure, in words and with its place.

use super::canvas::Canvas;
use super::{FRAME, Reading};
use crate::raster::PixelBox;
use crate::raster::bitmap::Bitmap;
use crate::raster::enclosed::parts;
use crate::raster::neighbourhood::dilated;
use crate::sketch::refusal::{Warning, WarningCode};

/// Ink that is left out is named where it takes this part of the figure's area, or reaches so far in parts of its size.
const NAMED_AREA: f64 = 0.01;
const NAMED_SIDE: f64 = 0.03;

/// Pixels beside a figure that are the softness of its edge.
const SOFT_EDGE: f64 = 3.0;

/// A point of a framed picture in the coordinates of the upload.
pub(super) fn upload_point(canvas: &Canvas, point: [f64; 2]) -> [f64; 2] {
    canvas.upload_point(point.map(|x| x - FRAME as f64))
}

/// A box of a framed picture in the coordinates of the upload.
pub(super) fn upload_box(canvas: &Canvas, bounds: PixelBox) -> [[f64; 2]; 2] {
    [bounds.low, bounds.high].map(|corner| upload_point(canvas, corner.map(|x| x as f64)))
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
    let near = dilated(&own.area, reading.rim + SOFT_EDGE);
    let touches = |[x, y]: [f64; 2]| near.get((x as usize).min(near.width() - 1), (y as usize).min(near.height() - 1));
    for gap in reading.gaps.iter().filter(|gap| touches(gap.place)) {
        let width = gap.width * canvas.pixel[0].max(canvas.pixel[1]);
        let place = upload_point(canvas, gap.place);
        warnings.push(
            Warning::new(WarningCode::ClosedGap, format!("a gap of {width:.1} in the line was closed")).at(place),
        );
    }
    for neck in &own.necks {
        warnings.extend(boxed(WarningCode::JoinedParts, "parts that lie apart were joined here", neck));
    }
    for limb in parts(&reading.limbs.and(&own.area), 1) {
        let detail = "a line that encloses nothing was taken for a limb of some width";
        warnings.extend(boxed(WarningCode::LineAsLimb, detail, &limb));
    }
    if own.area.and(&dilated(&reading.border, 1.0)).area() > 0 {
        let detail = "the figure runs over the border and ends there";
        warnings.push(Warning::new(WarningCode::CutByBorder, detail));
    }
    let mut rest = reading.ink.without(&near);
    for (_, other) in reading.figures.iter().enumerate().filter(|&(k, _)| k != figure) {
        rest = rest.without(&dilated(&other.area, reading.rim + SOFT_EDGE));
        warnings.extend(boxed(WarningCode::OtherFigure, "another figure was left out", &other.area));
    }
    let side = PixelBox::of(&own.area).map_or(0, PixelBox::side) as f64;
    for piece in parts(&rest, 1) {
        let Some(bounds) = PixelBox::of(&piece) else { continue };
        if piece.area() as f64 > NAMED_AREA * own.area.area() as f64 || bounds.side() as f64 > NAMED_SIDE * side {
            warnings.push(placed(WarningCode::LeftOut, "this was left out of the figure", bounds));
        }
    }
    warnings
}
