//! A drawing given as points, and the clean figure it bounds.

use std::fmt;

use serde::de::{Error as _, IgnoredAny, SeqAccess, Unexpected, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use utoipa::ToSchema;
use utoipa::openapi::schema::{ArrayBuilder, ObjectBuilder, Type};

use super::Config;
use super::arrangement::{Arrangement, Conflict, Contact, Place};
use super::refusal::{Fault, MAX_FAULTS, Refusal, Warning, WarningCode};
use super::ring::{Mended, Ring, cross, difference};
use super::untangling::untangled;

/// Coordinates beyond this leave no room for exact arithmetic.
const MAX_COORDINATE: f64 = 1e12;

/// A figure smaller than this part of its distance from the origin has lost its digits there.
const MIN_RELATIVE_SIZE: f64 = 1e-9;

/// How large a figure has to be, so that products of its lengths, and what is made of them, stay normal numbers.
const MIN_SIZE: f64 = 1e-40;

/// The least share of its bounding square that a figure fills; below it there is nothing to match.
const MIN_AREA: f64 = 1e-9;

/// A sketch as it is sent in JSON.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct OutlineRequest {
    /// Corners of the outer line, y up, in either direction; the last is joined to the first.
    #[serde(deserialize_with = "line")]
    #[schema(schema_with = outline_schema)]
    pub outline: Vec<[f64; 2]>,
    /// Lines inside the outline whose insides do not belong to the figure.
    #[serde(default, deserialize_with = "lines")]
    #[schema(schema_with = holes_schema)]
    pub holes: Vec<Vec<[f64; 2]>>,
    /// Vertices of the triangulation, 50 to 20,000, met within 10 % on ordinary outlines.
    #[serde(default, deserialize_with = "whole")]
    #[schema(value_type = usize, required = false, minimum = 50, maximum = 20000, default = 800)]
    pub target_vertices: Option<usize>,
}

/// The schema of a line of points: one derived from `[f64; 2]` says nothing of the length.
fn line_schema() -> ArrayBuilder {
    let coordinate = ObjectBuilder::new().schema_type(Type::Number);
    let point = ArrayBuilder::new().items(coordinate).min_items(Some(2)).max_items(Some(2));
    ArrayBuilder::new().items(point).min_items(Some(3))
}

fn outline_schema() -> ArrayBuilder {
    line_schema()
        .description(Some("Corners of the outer line, y up, in either direction; the last is joined to the first."))
}

fn holes_schema() -> ArrayBuilder {
    let holes = ArrayBuilder::new().items(line_schema());
    holes.description(Some("Lines inside the outline whose insides do not belong to the figure."))
}

/// A point as it is sent: an array of Rust would leave a third number to whoever reads on.
struct Sent([f64; 2]);

impl<'de> Deserialize<'de> for Sent {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Sent, D::Error> {
        deserializer.deserialize_seq(SentVisitor)
    }
}

struct SentVisitor;

impl<'de> Visitor<'de> for SentVisitor {
    type Value = Sent;

    fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str("a point of two numbers")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut numbers: A) -> Result<Sent, A::Error> {
        let x = numbers.next_element()?.ok_or_else(|| A::Error::invalid_length(0, &self))?;
        let y = numbers.next_element()?.ok_or_else(|| A::Error::invalid_length(1, &self))?;
        match numbers.next_element::<IgnoredAny>()? {
            Some(_) => Err(A::Error::invalid_length(3, &self)),
            None => Ok(Sent([x, y])),
        }
    }
}

fn line<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<[f64; 2]>, D::Error> {
    Ok(Vec::<Sent>::deserialize(deserializer)?.into_iter().map(|Sent(point)| point).collect())
}

fn lines<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<Vec<[f64; 2]>>, D::Error> {
    let lines = Vec::<Vec<Sent>>::deserialize(deserializer)?;
    Ok(lines.into_iter().map(|line| line.into_iter().map(|Sent(point)| point).collect()).collect())
}

/// A whole number, written with a fraction of zero or without, as JSON Schema has it.
fn whole<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<usize>, D::Error> {
    let number = f64::deserialize(deserializer)?;
    if number.fract() != 0.0 || number < 0.0 {
        return Err(D::Error::invalid_value(Unexpected::Float(number), &"a whole number from 0 on"));
    }
    Ok(Some(number as usize))
}

impl OutlineRequest {
    /// The drawing and the wanted number of vertices.
    pub fn into_parts(self) -> (Drawing, usize) {
        let vertices = self.target_vertices.unwrap_or(super::DEFAULT_TARGET_VERTICES);
        (Drawing { outline: self.outline, holes: self.holes }, vertices)
    }
}

/// One outer line and lines inside it that bound holes, y up.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Drawing {
    pub outline: Vec<[f64; 2]>,
    pub holes: Vec<Vec<[f64; 2]>>,
}

/// A clean figure: an outline counter-clockwise, then holes clockwise, that meet nowhere, in the unit square.
pub(super) struct Figure {
    pub rings: Vec<Vec<[f64; 2]>>,
    pub frame: UnitSquare,
}

/// Where the unit square of a figure lies in the drawing.
#[derive(Clone, Copy, Debug)]
pub(super) struct UnitSquare {
    centre: [f64; 2],
    size: f64,
}

impl UnitSquare {
    fn around(points: &[[f64; 2]]) -> Self {
        let low = [0, 1].map(|axis| points.iter().map(|p| p[axis]).fold(f64::INFINITY, f64::min));
        let high = [0, 1].map(|axis| points.iter().map(|p| p[axis]).fold(f64::NEG_INFINITY, f64::max));
        let [width, height] = difference(high, low);
        Self { centre: [0, 1].map(|axis| 0.5 * (low[axis] + high[axis])), size: width.max(height) }
    }

    fn unit_point(self, point: [f64; 2]) -> [f64; 2] {
        // Next to nothing is nothing: the exact predicates underflow below 2⁻¹⁴².
        difference(point, self.centre).map(|x| x / self.size).map(|x| if x.abs() < 1e-30 { 0.0 } else { x })
    }

    /// The point of the drawing that lies at `point` of the unit square.
    pub fn drawing_point(self, point: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| self.centre[axis] + self.size * point[axis])
    }
}

impl Figure {
    /// The figure that a drawing bounds, and what was mended: a repeated closing point, repeated points, points in the
    /// middle of straight lines, spikes of no width, small loops where a line crosses itself.
    ///
    /// Apart from such loops rings may not share a single point, not even with themselves: where a figure touches itself
    /// its surface is not a manifold there, and which parts belong together is for the drawer to say.
    ///
    /// # Errors
    /// Too many points; coordinates that are not finite or huge; rings that bound no area, cross or touch; holes that
    /// do not lie in the outline or lie in another hole. Each with its place.
    pub fn new(drawing: &Drawing, config: &Config) -> Result<(Self, Vec<Warning>), Refusal> {
        let rings: Vec<&[[f64; 2]]> =
            std::iter::once(&drawing.outline).chain(&drawing.holes).map(Vec::as_slice).collect();
        refuse(size_faults(&rings, config))?;
        refuse(coordinate_faults(&rings))?;
        let frame = UnitSquare::around(&drawing.outline);
        refuse(frame_faults(frame))?;
        let (mut clean, mended): (Vec<Ring>, Vec<Mended>) = rings
            .iter()
            .map(|ring| Ring::mended(&ring.iter().map(|&point| frame.unit_point(point)).collect::<Vec<_>>()))
            .unzip();
        refuse(empty_faults(&clean))?;
        refuse(reach_faults(&clean))?;
        let points: Vec<Vec<[f64; 2]>> = clean.iter().map(|ring| ring.points.clone()).collect();
        let mut crossed = Vec::new();
        let depths = match Arrangement::new(&points, MAX_FAULTS) {
            Ok(arrangement) => arrangement.depths(),
            Err(conflict) => match without_small_loops(&clean, &conflict) {
                Some((rings, of_rings, depths)) => {
                    (clean, crossed) = (rings, of_rings);
                    depths
                }
                None => return Err(Uploaded { rings, clean }.refusal(conflict)),
            },
        };
        refuse(nesting_faults(&depths))?;
        refuse(area_faults(&clean))?;
        let mut warnings: Vec<Warning> = (0..).zip(mended).flat_map(|(ring, mended)| mended.warnings(ring)).collect();
        warnings.extend(crossed.into_iter().map(|ring| {
            let detail = format!("{}: small loops where the line crosses itself were left out", ring_pointer(ring));
            Warning::new(WarningCode::SelfCrossing, detail)
        }));
        let rings = (0..).zip(clean).map(|(i, ring)| oriented(ring, i == 0)).collect();
        Ok((Self { rings, frame }, warnings))
    }
}

/// The rings without small loops, which of them had such, and how deep each lies in others; none where that does not
/// settle the conflict.
fn without_small_loops(clean: &[Ring], conflict: &Conflict) -> Option<(Vec<Ring>, Vec<usize>, Vec<usize>)> {
    let (rings, crossed) = untangled(clean, conflict, MAX_FAULTS)?;
    let points: Vec<Vec<[f64; 2]>> = rings.iter().map(|ring| ring.points.clone()).collect();
    let depths = Arrangement::new(&points, MAX_FAULTS).ok()?.depths();
    Some((rings, crossed, depths))
}

/// The ring's points counter-clockwise or clockwise.
fn oriented(ring: Ring, counter_clockwise: bool) -> Vec<[f64; 2]> {
    let turned = (ring.signed_area() > 0.0) != counter_clockwise;
    if turned { ring.reversed().points } else { ring.points }
}

fn refuse(faults: Vec<Fault>) -> Result<(), Refusal> {
    if faults.is_empty() { Ok(()) } else { Err(Refusal { faults }) }
}

/// JSON pointer of a ring: the outline, then the holes.
fn ring_pointer(ring: usize) -> String {
    if ring == 0 { "/outline".into() } else { format!("/holes/{}", ring - 1) }
}

fn point_pointer(ring: usize, point: usize) -> String {
    format!("{}/{point}", ring_pointer(ring))
}

fn size_faults(rings: &[&[[f64; 2]]], config: &Config) -> Vec<Fault> {
    let points: usize = rings.iter().map(|ring| ring.len()).sum();
    if points > config.max_points {
        return vec![Fault::plain(format!("{points} points; at most {} are taken", config.max_points))];
    }
    let few = (0..).zip(rings).filter(|(_, ring)| ring.len() < 3);
    few.map(|(i, ring)| Fault::of(ring_pointer(i), format!("{} points; a closed line needs three", ring.len())))
        .take(MAX_FAULTS)
        .collect()
}

fn coordinate_faults(rings: &[&[[f64; 2]]]) -> Vec<Fault> {
    let mut faults = Vec::new();
    for (ring, points) in rings.iter().enumerate() {
        let bad = points.iter().enumerate().filter(|(_, p)| p.iter().any(|x| x.is_nan() || x.abs() > MAX_COORDINATE));
        faults.extend(bad.take(MAX_FAULTS).map(|(i, &[x, y])| {
            let detail =
                format!("({x:?}, {y:?}) is not a point: coordinates must be numbers within ±{MAX_COORDINATE:e}");
            Fault::of(point_pointer(ring, i), detail)
        }));
    }
    faults.truncate(MAX_FAULTS);
    faults
}

fn frame_faults(frame: UnitSquare) -> Vec<Fault> {
    let distance = frame.centre[0].abs().max(frame.centre[1].abs());
    let detail = if frame.size == 0.0 {
        "all points lie at one place"
    } else if frame.size < MIN_SIZE {
        "the figure is too small: the least is 1e-40 across"
    } else if frame.size < MIN_RELATIVE_SIZE * distance {
        "the figure is too small for its distance from the origin: its points cannot be told apart"
    } else {
        return Vec::new();
    };
    vec![Fault::of("/outline", detail)]
}

fn empty_faults(rings: &[Ring]) -> Vec<Fault> {
    let empty = rings.iter().enumerate().filter(|(_, ring)| ring.points.len() < 3);
    empty
        .map(|(i, _)| Fault::of(ring_pointer(i), "the line encloses nothing: it has fewer than three distinct corners"))
        .take(MAX_FAULTS)
        .collect()
}

/// Holes that reach out of the outline's bounding square.
fn reach_faults(rings: &[Ring]) -> Vec<Fault> {
    let outside = |ring: &&(usize, &Ring)| ring.1.points.iter().flatten().any(|x| x.abs() > 0.5 + 1e-9);
    let numbered: Vec<(usize, &Ring)> = rings.iter().enumerate().collect();
    let faults =
        numbered.iter().filter(outside).map(|(i, _)| Fault::of(ring_pointer(*i), "the hole leaves the outline"));
    faults.take(MAX_FAULTS).collect()
}

fn nesting_faults(depths: &[usize]) -> Vec<Fault> {
    let holes = depths.iter().enumerate().skip(1).filter(|&(_, &depth)| depth != 1);
    holes
        .map(|(i, &depth)| {
            let detail =
                if depth == 0 { "the hole lies outside of the outline" } else { "the hole lies in another hole" };
            Fault::of(ring_pointer(i), detail)
        })
        .take(MAX_FAULTS)
        .collect()
}

fn area_faults(rings: &[Ring]) -> Vec<Fault> {
    let holes: f64 = rings[1..].iter().map(|ring| ring.signed_area().abs()).sum();
    if rings[0].signed_area().abs() - holes < MIN_AREA {
        return vec![Fault::of("/outline", "the figure has no area to speak of")];
    }
    Vec::new()
}

impl Mended {
    fn warnings(self, ring: usize) -> Vec<Warning> {
        let ring = ring_pointer(ring);
        let kinds = [
            (self.closing, WarningCode::ClosingPointRepeated, "repeats the first point at its end; it was left out"),
            (self.repeated, WarningCode::RepeatedPoints, "points that repeat the one before were left out"),
            (self.collinear, WarningCode::CollinearPoints, "points in the middle of straight lines were left out"),
            (self.spikes, WarningCode::Spikes, "tips of spikes without width were left out"),
        ];
        let found = kinds.into_iter().filter(|&(count, ..)| count > 0);
        found
            .map(|(count, code, detail)| {
                let number =
                    if code == WarningCode::ClosingPointRepeated { String::new() } else { format!("{count} ") };
                Warning::new(code, format!("{ring}: {number}{detail}"))
            })
            .collect()
    }
}

/// A drawing beside its mended rings: what is found in these is told in terms of that.
struct Uploaded<'a> {
    rings: Vec<&'a [[f64; 2]]>,
    clean: Vec<Ring>,
}

impl Uploaded<'_> {
    fn refusal(&self, conflict: Conflict) -> Refusal {
        match conflict {
            Conflict::Contacts(contacts) => {
                Refusal { faults: contacts.into_iter().map(|contact| self.fault(contact)).collect() }
            }
            Conflict::Coordinate(error) => Refusal::plain(format!("a coordinate cannot be used: {error}")),
        }
    }

    fn fault(&self, contact: Contact) -> Fault {
        match contact {
            Contact::Points(a, b) => {
                Fault::of(self.pointer(b), format!("the point is {} once more: lines may not touch", self.pointer(a)))
                    .at(self.point(b))
            }
            Contact::EdgePoint(edge, point) => {
                let detail =
                    format!("the line to the next point runs through {}: lines may not touch", self.pointer(point));
                Fault::of(self.pointer(edge), detail).at(self.point(point))
            }
            Contact::Edges(a, b) => {
                let [from, to] = [a, self.after(a)].map(|place| self.pointer(place));
                let detail = format!("the line to the next point crosses the line from {from} to {to}");
                Fault::of(self.pointer(b), detail).at(self.crossing(a, b))
            }
        }
    }

    fn after(&self, Place { ring, position }: Place) -> Place {
        Place { ring, position: (position + 1) % self.clean[ring].points.len() }
    }

    fn origin(&self, Place { ring, position }: Place) -> usize {
        self.clean[ring].origin[position]
    }

    fn pointer(&self, place: Place) -> String {
        point_pointer(place.ring, self.origin(place))
    }

    fn point(&self, place: Place) -> [f64; 2] {
        self.rings[place.ring][self.origin(place)]
    }

    /// Where two edges that cross do so.
    fn crossing(&self, a: Place, b: Place) -> [f64; 2] {
        let [p, r] = [self.point(a), self.point(b)];
        let [u, v] = [difference(self.point(self.after(a)), p), difference(self.point(self.after(b)), r)];
        let t = cross(difference(r, p), v) / cross(u, v);
        if t.is_finite() { [0, 1].map(|axis| p[axis] + t * u[axis]) } else { p }
    }
}
