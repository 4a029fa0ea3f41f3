//! The alignment of views within a match: its stage, and what the result says of it.

use super::outcome::{AlignmentReport, Alternative, AlternativeKind, MatchedBy, SeenPart, ViewReport};
use super::request::{Direction, Part, Ups};
use super::settings::Settings;
use super::{MatchError, Surroundings};
use crate::alignment::prepared::standing::Up;
use crate::alignment::prepared::{FlatShape, PreparedMesh};
use crate::alignment::{self, Alignment, Pair, Upright, Way};
use crate::geometry::axes::Axes;
use crate::geometry::frame::Frame;
use crate::geometry::{dot, unit};
use crate::mesh::figure::Figure;
use crate::mesh::normals::normals;
use crate::numerics::Watch;
use crate::sketch::Sketch;

/// How far behind the plane of symmetry a vertex still belongs to the side in front, in units of √area.
const BEYOND: f64 = 0.02;

/// The sketch laid on the figure of the mesh, and the vertices that may be matched.
pub(super) struct Aligned {
    pub alignment: Alignment,
    /// Those its frames are told in.
    axes: Axes,
    pub part: SeenPart,
    /// Vertices of the figure on the part that is seen, ascending.
    pub visible: Vec<u32>,
}

/// The sketch laid on the figure as the settings ask for it. Landmarks are pairs of vertices. `first`, where
/// somebody asks, is told what it looks like at first sight.
pub(super) fn aligned(
    sketch: &Sketch,
    figure: &Figure,
    landmarks: &[[usize; 2]],
    settings: &Settings,
    surroundings: &Surroundings<'_>,
    first: Option<&dyn Fn(Aligned)>,
    watch: &dyn Watch,
) -> Result<Aligned, MatchError> {
    let prepared = &*surroundings.preparations.prepared(&figure.mesh, watch)?;
    let shape = FlatShape::new(sketch.mesh(), watch)?.with_eyes(sketch.eyes());
    let pairs: Vec<Pair> = landmarks.iter().map(|&[x, y]| Pair { sketch: x as u32, mesh: y as u32 }).collect();
    let upright = upright(&settings.up, sketch, &shape, prepared);
    let of = |alignment| Aligned::of(alignment, prepared, settings.part);
    let first = first.map(|first| move |alignment| first(of(alignment)));
    let first = first.as_ref().map(|first| first as &dyn Fn(Alignment));
    Ok(of(alignment::aligned(&shape, prepared, upright, &pairs, first, watch)?))
}

/// Which way is up on both shapes, in the axes they are laid in; nothing where it is not known of one of them.
fn upright(up: &Ups, sketch: &Sketch, shape: &FlatShape, prepared: &PreparedMesh) -> Option<Upright> {
    let drawn = match up.sketch {
        None => [0.0, 1.0],
        Some(Direction::Along(direction)) => sketch.to_internal(direction),
        Some(Direction::Unknown(_)) => return None,
    };
    let standing = match up.mesh {
        None => Some(prepared.up(None)).filter(Up::is_sure)?.direction,
        Some(Direction::Along(direction)) => direction,
        Some(Direction::Unknown(_)) => return None,
    };
    let length = drawn[0].hypot(drawn[1]);
    let sketch = shape.turned(drawn.map(|x| x / length));
    Some(Upright { sketch, mesh: prepared.axes.along(unit(standing)) })
}

impl Aligned {
    fn of(alignment: Alignment, prepared: &PreparedMesh, part: Part) -> Aligned {
        let toward = alignment.frame.toward_camera;
        let side = dot(prepared.symmetry.normal, toward).signum();
        let on_side = |v: &u32| side * prepared.symmetry.height(prepared.positions[*v as usize]) > -BEYOND;
        let part = match part {
            Part::Whole => SeenPart::Whole,
            Part::Side => SeenPart::Side,
            // Of many poses a far leg is seen too.
            Part::Auto if alignment.sideways && alignment.map.iter().all(on_side) => SeenPart::Side,
            Part::Auto => SeenPart::Whole,
        };
        let vertices = 0..prepared.positions.len() as u32;
        let visible = match part {
            SeenPart::Whole => vertices.collect(),
            SeenPart::Side if alignment.sideways => vertices.filter(on_side).collect(),
            // Seen from the front neither half of the body is before the other.
            SeenPart::Side => {
                let normals = normals(&prepared.positions, &prepared.triangles);
                vertices.filter(|v| dot(normals[*v as usize], toward) > 0.0).collect()
            }
        };
        Aligned { alignment, axes: prepared.axes, part, visible }
    }

    /// What the result says of the alignment, in the numbering of the user's mesh.
    pub fn report(&self, figure: &Figure) -> AlignmentReport {
        let alignment = &self.alignment;
        AlignmentReport {
            view: self.view(&alignment.frame),
            part: self.part,
            by: match alignment.way {
                Way::View => MatchedBy::View,
                Way::Pose => MatchedBy::Pose,
                Way::Distances => MatchedBy::Distances,
            },
            contour_cost: alignment.contour,
            distortion: alignment.distortion,
            score: alignment.score,
            mesh_vertices: of_file(figure, &alignment.map),
        }
    }

    pub fn alternatives(&self, figure: &Figure) -> Vec<Alternative> {
        let alternatives = self.alignment.alternatives.iter();
        alternatives
            .map(|alternative| Alternative {
                kind: if alternative.mirrored { AlternativeKind::Mirrored } else { AlternativeKind::View },
                view: self.view(&alternative.frame),
                score: alternative.score,
                mesh_vertices: of_file(figure, &alternative.map),
            })
            .collect()
    }

    fn view(&self, frame: &Frame) -> ViewReport {
        let Frame { toward_camera, up, .. } = self.axes.frame_back(frame);
        ViewReport { toward_camera, up }
    }
}

fn of_file(figure: &Figure, map: &[u32]) -> Vec<u32> {
    map.iter().map(|&v| figure.vertices[v as usize]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::solids::star;
    use crate::numerics::Unwatched;

    #[test]
    fn the_side_towards_the_camera_is_half_a_left_one_and_half_a_right_one_from_the_front() {
        let prepared = PreparedMesh::new(&star(0.0), &Unwatched).unwrap();
        let (normal, along) = (prepared.symmetry.normal, prepared.axes.along([0.0, 1.0, 0.0]));
        assert!(dot(normal, along).abs() < 0.01);
        for (toward_camera, sideways) in [(along, false), (normal, true)] {
            let alignment = Alignment {
                map: Vec::new(),
                places: Vec::new(),
                confidence: Vec::new(),
                frame: Frame::looking_from(toward_camera),
                way: Way::View,
                sideways,
                contour: 0.0,
                distortion: 0.0,
                score: 0.0,
                alternatives: Vec::new(),
                at_odds: Vec::new(),
            };
            let aligned = Aligned::of(alignment, &prepared, Part::Side);
            let share = |direction| {
                let along = |v: &&u32| dot(prepared.positions[**v as usize], direction) > 0.0;
                aligned.visible.iter().filter(along).count() as f64 / aligned.visible.len() as f64
            };
            assert!(share(toward_camera) > 0.8, "{}", share(toward_camera));
            assert!(sideways || (share(normal) - 0.5).abs() < 0.1, "{}", share(normal));
        }
    }
}
