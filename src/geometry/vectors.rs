//! Vectors of space.

/// The vector from b to a.
pub fn subtract(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// The scalar product.
pub fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The vector product: at right angles to both, as long as the parallelogram they span is large.
pub fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The Euclidean norm.
pub fn length(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

/// The vector at length 1.
pub fn unit(vector: [f64; 3]) -> [f64; 3] {
    let length = length(vector);
    vector.map(|x| x / length)
}
