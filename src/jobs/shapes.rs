//! The shapes a job needs, and which of them a mesh is of that is computed on.

use crate::mesh::TriangleMesh;
use crate::store::Job;

/// The ids of a job's mesh and sketch.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Shapes {
    mesh: Option<String>,
    sketch: Option<String>,
}

impl From<&Job> for Shapes {
    fn from(job: &Job) -> Shapes {
        Shapes { mesh: job.mesh.clone(), sketch: job.sketch.clone() }
    }
}

impl Shapes {
    /// Those of a match.
    pub fn of_match(mesh: &str, sketch: &str) -> Shapes {
        Shapes { mesh: Some(mesh.to_owned()), sketch: Some(sketch.to_owned()) }
    }

    /// The shape that `part` is of, which tells for how long what is made of it is kept. Sketches lie in the plane z = 0; of a
    /// mesh that does too it would only be computed again.
    pub fn of(&self, part: &TriangleMesh) -> Option<&str> {
        let flat = part.positions().iter().all(|position| position[2] == 0.0);
        let (first, second) = if flat { (&self.sketch, &self.mesh) } else { (&self.mesh, &self.sketch) };
        first.as_deref().or(second.as_deref())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_flat_is_of_the_sketch() {
        let triangle = |z| TriangleMesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.3, 1.0, z]], vec![[0, 1, 2]]).unwrap();
        let named = |name: &str| Some(name.to_owned());
        let both = Shapes { mesh: named("m"), sketch: named("s") };
        assert_eq!((both.of(&triangle(0.0)), both.of(&triangle(0.5))), (Some("s"), Some("m")));
        let mesh = Shapes { mesh: named("m"), sketch: None };
        assert_eq!((mesh.of(&triangle(0.0)), Shapes::default().of(&triangle(0.0))), (Some("m"), None));
    }
}
