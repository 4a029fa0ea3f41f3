//! The requests of an experiment: every combination of what its axes name.

use std::collections::BTreeMap;

use serde_json::{Map, Value};

/// Combinations at most.
const MOST: usize = 10_000;

/// The axes of an experiment, each with parts of a match request under names.
pub type Matrix = Vec<BTreeMap<String, Map<String, Value>>>;

/// One request of a matrix.
#[derive(Clone, Debug, PartialEq)]
pub struct Combination {
    /// The name along each axis.
    pub names: Vec<String>,
    pub request: Map<String, Value>,
}

impl Combination {
    /// All its names.
    pub fn name(&self) -> String {
        self.names.join(" ")
    }
}

/// A matrix that cannot be carried out.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Unfit {
    #[error("axis {0} of the matrix names nothing")]
    Empty(usize),
    #[error("\"{0}\" cannot be the name of a folder: letters, digits and - _ . = are taken")]
    Name(String),
    #[error("the matrix has more than {MOST} combinations")]
    TooLarge,
}

/// Every combination of a matrix, the last axis running fastest; names within an axis in their order. What a later axis
/// says of a member takes the place of what earlier ones say, objects are joined member by member.
///
/// # Errors
/// [`Unfit`].
pub fn combinations(matrix: &Matrix) -> Result<Vec<Combination>, Unfit> {
    let mut all = vec![Combination { names: Vec::new(), request: Map::new() }];
    for (number, axis) in matrix.iter().enumerate() {
        if axis.is_empty() {
            return Err(Unfit::Empty(number));
        }
        if let Some(name) = axis.keys().find(|name| !is_plain(name)) {
            return Err(Unfit::Name(name.clone()));
        }
        if all.len().saturating_mul(axis.len()) > MOST {
            return Err(Unfit::TooLarge);
        }
        let with = |before: &Combination, (name, part): (&String, &Map<String, Value>)| {
            let mut combination = before.clone();
            combination.names.push(name.clone());
            join(&mut combination.request, part);
            combination
        };
        all = all.iter().flat_map(|before| axis.iter().map(|entry| with(before, entry)).collect::<Vec<_>>()).collect();
    }
    Ok(all)
}

/// Whether a name can be that of a folder everywhere.
fn is_plain(name: &str) -> bool {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_.=".contains(c);
    !name.is_empty() && !name.starts_with('.') && name.len() <= 100 && name.chars().all(plain)
}

fn join(request: &mut Map<String, Value>, part: &Map<String, Value>) {
    for (name, value) in part {
        match (request.get_mut(name), value) {
            (Some(Value::Object(before)), Value::Object(after)) => join(before, after),
            _ => {
                request.insert(name.clone(), value.clone());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use serde_json::{from_value, json};

    use super::*;

    #[test]
    fn the_last_axis_runs_fastest_and_objects_are_joined() {
        let matrix: Matrix = from_value(json!([
            {"a": {"preset": "thesis", "descriptors": {"hks": {"count": 0}}}},
            {"x": {"descriptors": {"wks": {"count": 9}}}, "y": {"descriptors": {"hks": {"count": 5}}}},
        ]))
        .unwrap();
        let all = combinations(&matrix).unwrap();
        let names: Vec<String> = all.iter().map(Combination::name).collect();
        assert_eq!(names, ["a x", "a y"]);
        let x = json!({"preset": "thesis", "descriptors": {"hks": {"count": 0}, "wks": {"count": 9}}});
        assert_eq!(Value::Object(all[0].request.clone()), x);
        assert_eq!(all[1].request["descriptors"], json!({"hks": {"count": 5}}));
        assert_eq!(combinations(&Matrix::new()).unwrap().len(), 1);
    }

    #[test]
    fn what_is_no_matrix_is_refused() {
        let axis = |names: &[&str]| names.iter().map(|name| ((*name).to_owned(), Map::new())).collect();
        assert_eq!(combinations(&vec![axis(&[])]), Err(Unfit::Empty(0)));
        for name in ["../up", "", ".", "a b", "ä"] {
            assert_eq!(combinations(&vec![axis(&[name])]), Err(Unfit::Name(name.to_owned())));
        }
        let ten: Vec<String> = (0..10).map(|i| i.to_string()).collect();
        let ten: Vec<&str> = ten.iter().map(String::as_str).collect();
        assert_eq!(combinations(&vec![axis(&ten); 5]), Err(Unfit::TooLarge));
    }
}
