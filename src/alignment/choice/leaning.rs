//! Which way is up in a drawing that leans on its sheet.

use super::attempt::{Attempt, attempts};
use crate::alignment::error::AlignmentError;
use crate::alignment::scene::Scene;
use crate::alignment::scene::landmarks::Landmarks;
use crate::alignment::search::candidates::{Candidate, Kind, candidates, canonical};

/// How far a drawing may lean to either side, in degrees: leaning by half as much hardly matters.
const LEANING: [f64; 2] = [-30.0, 30.0];
/// What speaks against leaning beside the score of an attempt.
const LEANING_PRICE: f64 = 0.045;

/// What is seen at first sight, before poses are looked for.
pub struct FirstLook<'a> {
    /// The scene, up being where it is in the drawing.
    pub scene: Scene<'a>,
    pub candidates: Vec<Candidate>,
    /// At least one, best first.
    pub attempts: Vec<Attempt>,
}

/// What the drawing is at first sight: standing as its sheet does, or leaning where an outline is nearer then and the best
/// attempt scores so much less.
///
/// # Errors
/// [`AlignmentError`].
pub fn first_look<'a>(scene: Scene<'a>, none: &Landmarks) -> Result<FirstLook<'a>, AlignmentError> {
    let views = candidates(&scene)?;
    let straight = attempts(&scene, &views, none)?;
    let (nearest, mut least) = (least_cost(&views), least_score(&straight) - LEANING_PRICE);
    let mut leaning = None;
    for degrees in LEANING {
        let Some(scene) = scene.leaning(degrees) else { break };
        let views = canonical(&scene)?;
        if least_cost(&views) < nearest {
            let score = least_score(&attempts(&scene, &views, none)?);
            if score < least {
                (least, leaning) = (score, Some(scene));
            }
        }
    }
    let Some(scene) = leaning else { return Ok(FirstLook { scene, candidates: views, attempts: straight }) };
    let candidates = candidates(&scene)?;
    let attempts = attempts(&scene, &candidates, none)?;
    Ok(FirstLook { scene, candidates, attempts })
}

/// The least cost of the outlines of canonical views.
fn least_cost(candidates: &[Candidate]) -> f64 {
    let canonical = candidates.iter().filter(|candidate| matches!(candidate.kind, Kind::Canonical(_)));
    canonical.map(|candidate| candidate.warp.cost).fold(f64::INFINITY, f64::min)
}

fn least_score(attempts: &[Attempt]) -> f64 {
    attempts.first().map_or(f64::INFINITY, Attempt::score)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::alignment::prepared::{FlatShape, PreparedMesh};
    use crate::alignment::scene::upright::Upright;
    use crate::example::Creature;
    use crate::numerics::Unwatched;
    use crate::sketch::outline::Drawing;
    use crate::sketch::{Config, from_outline};

    /// How far the first look takes the silhouette of a creature to lean on a sheet turned by an angle, in degrees.
    fn lean(creature: Creature, degrees: f64) -> f64 {
        let mesh = creature.mesh(1500).unwrap();
        let silhouette = creature.silhouette(&mesh).unwrap();
        let drawing = Drawing { outline: silhouette.outline, holes: silhouette.holes };
        let sketch = from_outline(&drawing, 400, &Config::default()).unwrap().sketch;
        let (shape, mesh) =
            (FlatShape::new(sketch.mesh(), &Unwatched).unwrap(), PreparedMesh::new(&mesh, &Unwatched).unwrap());
        let up = Upright { sketch: shape.turned([0.0, 1.0]), mesh: mesh.axes.along(mesh.up(None).direction) };
        let straight = Scene::new(&shape, &mesh, Some(up), &Unwatched);
        let none = Landmarks::new(&shape, &[], &Unwatched).unwrap();
        let look = first_look(straight.leaning(degrees).unwrap(), &none).unwrap();
        let [[x, y], [u, v]] = [look.scene, straight].map(|scene| scene.upright.unwrap().sketch);
        (u * y - v * x).atan2(x * u + y * v).to_degrees() - degrees
    }

    #[test]
    fn a_drawing_far_from_upright_leans_and_one_that_stands_does_not() {
        assert!((lean(Creature::Quadruped, 60.0) + 30.0).abs() < 1e-9);
        for creature in [Creature::Quadruped, Creature::Biped] {
            assert!(lean(creature, 0.0).abs() < 1e-9, "{}", creature.name());
        }
    }
}
