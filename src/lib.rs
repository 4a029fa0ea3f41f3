//! Dense matching of a 2D sketch to a 3D mesh by functional maps.
//!
//! The modules stand in floor order: a module imports from those above it in this list only. `http` and `worker` never
//! name each other; they meet in `store` and `jobs`. `cargo check --lib --no-default-features` builds the pure floors alone and is
//! the proof that the method needs neither a runtime nor a database.

// Floor 1: pure. No tokio, no input or output, no clock.

/// Solvers that know operators, not meshes: sparse factorisation, block Lanczos, least squares, conjugate gradient,
/// proximal gradient, proximal operators, CoSaMP, and the report every iteration leaves behind.
pub mod numerics;

/// Vectors, frames, axes and areas.
pub mod geometry;

/// A valid triangle mesh, what is measured on it, and the file formats it arrives in.
pub mod mesh;

/// Pictures in black and white: their pieces, what lies near, what they enclose, and the lines round them; the silhouette
/// of triangles and the surface in front.
pub mod raster;

/// A drawing and the flat mesh made of it.
pub mod sketch;

/// The Laplacian of a mesh and its eigenpairs.
pub mod spectral;

/// Shapes led to other places and bent as little as may be; drawings moved by handles, and their deformation transferred to
/// a surface.
pub mod deformation;

/// A sketch laid on a mesh without a click: prepared shapes, contours, search, laying, choice.
pub mod alignment;

/// Consensus segmentation and the pairing of regions.
pub mod regions;

/// Point descriptors made of eigenpairs: heat kernel, wave kernel, global point signature.
pub mod descriptors;

/// The energy of a functional map and its minimiser: problem, weights, regulariser, solve.
pub mod functional_map;

/// From a functional map to points, and the refinement of both.
pub mod correspondence;

/// How far an answer is from the truth: geodesic error curves.
pub mod evaluation;

/// What people look at: a match as coloured figures, the functional map as a heat map, the mesh in colours.
pub mod picture;

/// The example creatures: implicit bodies, their views and the true correspondence.
pub mod example;

// Floor 2: pure.

/// The method in order: request, stages, outcome.
pub mod pipeline;

/// The application of a match: the mesh posed by its drawing.
pub mod posing;

/// What a match is for besides: functions, labels and colours taken from one shape to the other.
pub mod transfer;

// Floor 3.

/// What chooses between the attempts of an alignment, fitted to cases whose truth is known.
#[cfg(feature = "service")]
pub mod fitting;

/// Who may do what: tenants, scopes, and the keys that open them.
#[cfg(feature = "service")]
pub mod access;

/// Of which trace a piece of work is part.
#[cfg(feature = "service")]
pub mod traces;

/// TLS of what goes out.
#[cfg(feature = "service")]
pub mod tls;

/// Calls that tell others of the end of a job: to whom they may go, how they are signed and made.
#[cfg(feature = "service")]
pub mod webhooks;

/// All SQL and all blobs: shapes, the queue with its leases, cached spectra, results.
#[cfg(feature = "service")]
pub mod store;

/// What comes in: bytes taken as meshes, sketches and values, with all that is to be said of them.
#[cfg(feature = "service")]
pub mod intake;

/// What is stored, written out: tables, arrays, pictures, coloured meshes.
#[cfg(feature = "service")]
pub mod export;

/// Many requests over many cases whose truth is known, judged, as tables and plots.
#[cfg(feature = "service")]
pub mod experiments;

/// What can be put into the queue: each kind of job with what it needs, does and answers.
#[cfg(feature = "service")]
pub mod jobs;

// Floor 4.

/// Claims a job, runs it on the bounded pool, reports.
#[cfg(feature = "service")]
pub mod worker;

/// Routes, their bodies, problem details, OpenAPI.
#[cfg(feature = "service")]
pub mod http;
