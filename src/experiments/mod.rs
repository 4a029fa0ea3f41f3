//! Many requests over many cases whose truth is known.
//!
//! A [matrix](matrix) of requests is matched over folders of cases ([`run`]), each answer judged and kept, so that what was
//! interrupted goes on where it stopped; what all come to is written as tables and plots ([`tables`]).

pub mod chapter4;
pub mod figures;
pub mod kept;
pub mod matrix;
pub mod run;
pub mod tables;
