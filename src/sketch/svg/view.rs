//! The way from the canvas, which usvg draws on, back to the user units of the `viewBox`.

use crate::sketch::refusal::Refusal;
use usvg::Size;
use usvg::roxmltree::Document;
use usvg::tiny_skia_path::Point;

/// Canvas = scale · user + shift, per axis.
pub(super) struct View {
    scale: [f64; 2],
    shift: [f64; 2],
}

impl View {
    /// The view of a document that is drawn on a canvas of this size: the rules of `viewBox` and
    /// `preserveAspectRatio`. Without a `viewBox` user units are those of the canvas.
    pub fn of(document: &Document, size: Size) -> Self {
        let canvas = [f64::from(size.width()), f64::from(size.height())];
        let root = document.root_element();
        let Some([x, y, width, height]) = root.attribute("viewBox").and_then(numbers) else {
            return Self { scale: [1.0; 2], shift: [0.0; 2] };
        };
        let aspect = root.attribute("preserveAspectRatio").unwrap_or("xMidYMid meet");
        let fit = [canvas[0] / width, canvas[1] / height];
        let scale = if aspect.starts_with("none") {
            fit
        } else if aspect.ends_with("slice") {
            [fit[0].max(fit[1]); 2]
        } else {
            [fit[0].min(fit[1]); 2]
        };
        let placed = ["x", "Y"].map(|axis| {
            let is = |place: &str| aspect.contains(&format!("{axis}{place}"));
            if aspect.starts_with("none") || is("Min") {
                0.0
            } else if is("Max") {
                1.0
            } else {
                0.5
            }
        });
        let (low, extent) = ([x, y], [width, height]);
        let shift = [0, 1].map(|i| placed[i] * (canvas[i] - scale[i] * extent[i]) - scale[i] * low[i]);
        Self { scale, shift }
    }

    /// A point of the canvas in user units.
    pub fn user(&self, point: Point) -> [f64; 2] {
        let point = [point.x, point.y].map(f64::from);
        [0, 1].map(|i| (point[i] - self.shift[i]) / self.scale[i])
    }
}

/// Largest number of a `viewBox`, and one over the least extent: what is drawn has single precision.
const LARGEST: f64 = 1e12;

/// Refuses a `viewBox` that is too large, too far away or too small to draw on.
pub(super) fn check(document: &Document) -> Result<(), Refusal> {
    let view_box = document.root_element().attribute("viewBox").and_then(numbers);
    let is_extreme = |[x, y, width, height]: [f64; 4]| {
        [x, y, width, height].iter().any(|number| number.abs() > LARGEST) || width.min(height) < 1.0 / LARGEST
    };
    if view_box.is_some_and(is_extreme) {
        return Err(Refusal::plain(format!(
            "the numbers of the SVG's viewBox are too extreme: at most {LARGEST:e} are taken"
        )));
    }
    Ok(())
}

/// The four numbers of a `viewBox` that has an extent.
fn numbers(text: &str) -> Option<[f64; 4]> {
    let words = text.split([' ', ',', '\t', '\n', '\r']).filter(|word| !word.is_empty());
    let numbers: Vec<f64> = words.map(str::parse).collect::<Result<_, _>>().ok()?;
    let numbers: [f64; 4] = numbers.try_into().ok()?;
    (numbers.iter().all(|x| x.is_finite()) && numbers[2] > 0.0 && numbers[3] > 0.0).then_some(numbers)
}
