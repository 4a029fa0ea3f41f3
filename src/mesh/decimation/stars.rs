//! The triangles about each vertex.

/// The triangles about each vertex of a list of triangles, one vertex after the other.
pub(super) struct Stars<'a> {
    triangles: &'a [[u32; 3]],
    /// Per vertex where its corners begin, and the end of all.
    starts: Vec<u32>,
    /// Corner `h % 3` of triangle `h / 3`.
    corners: Vec<u32>,
}

impl Stars<'_> {
    pub fn of(vertices: usize, triangles: &[[u32; 3]]) -> Stars<'_> {
        let named = triangles.as_flattened();
        let mut starts = vec![0u32; vertices + 1];
        named.iter().for_each(|&v| starts[v as usize] += 1);
        let mut end = 0;
        for start in &mut starts {
            end += *start;
            *start = end;
        }
        let mut corners = vec![0; named.len()];
        // From the last, so that those of a vertex ascend.
        for (h, &v) in named.iter().enumerate().rev() {
            let start = &mut starts[v as usize];
            *start -= 1;
            corners[*start as usize] = h as u32;
        }
        Stars { triangles, starts, corners }
    }

    /// Number of triangles about a vertex.
    pub fn size(&self, v: u32) -> usize {
        (self.starts[v as usize + 1] - self.starts[v as usize]) as usize
    }

    /// The other two corners of each triangle about a vertex, in its winding.
    pub fn sides(&self, v: u32) -> impl Iterator<Item = [u32; 2]> + Clone {
        let [start, end] = [0, 1].map(|i| self.starts[v as usize + i] as usize);
        self.corners[start..end].iter().map(|&h| {
            let (triangle, corner) = (self.triangles[h as usize / 3], h as usize % 3);
            [triangle[(corner + 1) % 3], triangle[(corner + 2) % 3]]
        })
    }
}
