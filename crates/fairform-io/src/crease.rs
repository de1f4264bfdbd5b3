//! Sharp edges and vertices: the tags of OpenSubdiv's OBJ shapes, and JSON as in USD.

use fairform::topology::Topology;
use fairform::{Creases, EdgeId, VertexId};
use serde::Deserialize;

use crate::error::{ParseError, Place};

/// Sharp edges and vertices by vertex number, as a file has them.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct CreaseList {
    /// Ends and sharpness of edges.
    pub edges: Vec<([u32; 2], f64)>,
    /// Sharp vertices.
    pub vertices: Vec<(u32, f64)>,
    /// Whether corners of the boundary are to be kept, if the file says.
    pub keep_corners: Option<bool>,
}

/// As in `UsdGeomMesh`.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
struct Json {
    #[serde(default)]
    crease_indices: Vec<u32>,
    #[serde(default)]
    crease_lengths: Vec<usize>,
    #[serde(default)]
    crease_sharpnesses: Vec<f64>,
    #[serde(default)]
    corner_indices: Vec<u32>,
    #[serde(default)]
    corner_sharpnesses: Vec<f64>,
    interpolate_boundary: Option<String>,
}

/// Reads creases: JSON if the text begins with a brace, otherwise the `t` lines of an OBJ file.
///
/// JSON has the fields of a USD mesh: `creaseIndices`, `creaseLengths`, `creaseSharpnesses` (one per
/// crease, or one per edge), `cornerIndices`, `cornerSharpnesses`, `interpolateBoundary` (`none`,
/// `edgeOnly`, `edgeAndCorner`). OBJ has lines such as `t crease 2/1/0 0 1 4.0`, `t corner 1/1/0 7 10`
/// and `t interpolateboundary 1/0/0 2`, with vertices counted from 0.
///
/// # Errors
/// With the line, or for JSON the place, and what was expected.
pub fn parse_creases(bytes: &[u8]) -> Result<CreaseList, ParseError> {
    let text = String::from_utf8_lossy(bytes);
    if text.trim_start().starts_with('{') { json(&text) } else { obj(&text) }
}

fn wrong(place: Place, message: impl Into<String>, expected: &str) -> ParseError {
    ParseError { place, message: message.into(), expected: Some(expected.into()) }
}

fn json(text: &str) -> Result<CreaseList, ParseError> {
    let json: Json = serde_json::from_str(text)
        .map_err(|e| wrong(Place::Line(e.line() as u64), e.to_string(), "creases as in USD"))?;
    let mut list = CreaseList::default();
    let (lengths, sharp) = (&json.crease_lengths, &json.crease_sharpnesses);
    let edge_count: usize = lengths.iter().map(|n| n.saturating_sub(1)).sum();
    let per_edge = sharp.len() == edge_count && sharp.len() != lengths.len();
    if !per_edge && sharp.len() != lengths.len() {
        let message = format!("{} crease sharpnesses for {} creases", sharp.len(), lengths.len());
        return Err(wrong(Place::File, message, "one per crease, or one per edge"));
    }
    let mut rest = json.crease_indices.as_slice();
    let mut edge = 0;
    for (i, &length) in lengths.iter().enumerate() {
        if length < 2 || length > rest.len() {
            let message = format!("crease {i} has {length} of {} vertices left", rest.len());
            return Err(wrong(
                Place::File,
                message,
                "at least 2 vertices, and as many as there are",
            ));
        }
        let (own, others) = rest.split_at(length);
        rest = others;
        for ends in own.windows(2) {
            list.edges.push(([ends[0], ends[1]], sharp[if per_edge { edge } else { i }]));
            edge += 1;
        }
    }
    if !rest.is_empty() {
        let message = format!("{} crease indices belong to no crease", rest.len());
        return Err(wrong(Place::File, message, "creaseLengths that add up to creaseIndices"));
    }
    if json.corner_indices.len() != json.corner_sharpnesses.len() {
        let message = format!(
            "{} corner sharpnesses for {} corners",
            json.corner_sharpnesses.len(),
            json.corner_indices.len()
        );
        return Err(wrong(Place::File, message, "one per corner"));
    }
    list.vertices = json.corner_indices.into_iter().zip(json.corner_sharpnesses).collect();
    list.keep_corners = match json.interpolate_boundary.as_deref() {
        None => None,
        Some("edgeAndCorner") => Some(true),
        Some("edgeOnly") => Some(false),
        Some(other) => {
            let message = format!("interpolateBoundary is {other:?}");
            return Err(wrong(Place::File, message, "edgeOnly or edgeAndCorner"));
        }
    };
    Ok(list)
}

fn obj(text: &str) -> Result<CreaseList, ParseError> {
    let mut list = CreaseList::default();
    for (number, line) in (1..).zip(text.lines()) {
        let line = line.split('#').next().unwrap_or_default();
        let mut words = line.split_whitespace();
        if words.next() != Some("t") {
            continue;
        }
        let place = Place::Line(number);
        let name = words.next().unwrap_or_default();
        let counts = words.next().and_then(|counts| {
            let mut counts = counts.split('/').map(|n| n.parse::<usize>().ok());
            Some([counts.next()??, counts.next()??])
        });
        let Some([ints, floats]) = counts else {
            return Err(wrong(place, "a tag without counts", "t NAME INTS/FLOATS/STRINGS …"));
        };
        let values: Vec<&str> = words.collect();
        let enough = ints.checked_add(floats).is_some_and(|n| n <= values.len());
        let int = |i: usize| values.get(i).filter(|_| i < ints).and_then(|w| w.parse::<u32>().ok());
        let float = |i: usize| {
            let value = values.get(ints + i).filter(|_| enough && i < floats);
            value.and_then(|w| w.parse::<f64>().ok()).filter(|s| *s >= 0.0)
        };
        match name {
            "crease" => {
                let Some((ends, sharpness)) =
                    (|| Some(((0..ints).map(int).collect::<Option<Vec<_>>>()?, float(0)?)))()
                        .filter(|(ends, _)| ends.len() >= 2)
                else {
                    return Err(wrong(
                        place,
                        "a bad crease",
                        "t crease 2/1/0 VERTEX VERTEX SHARPNESS",
                    ));
                };
                list.edges.extend(ends.windows(2).map(|w| ([w[0], w[1]], sharpness)));
            }
            "corner" => {
                let corners = (0..ints).map(int).collect::<Option<Vec<_>>>();
                let (Some(corners), Some(sharpness)) = (corners, float(0)) else {
                    return Err(wrong(place, "a bad corner", "t corner 1/1/0 VERTEX SHARPNESS"));
                };
                list.vertices.extend(corners.into_iter().map(|v| (v, sharpness)));
            }
            "interpolateboundary" => {
                let Some(choice @ 1..=2) = int(0) else {
                    let expected = "1 (edges) or 2 (edges and corners)";
                    return Err(wrong(place, "a bad boundary choice", expected));
                };
                list.keep_corners = Some(choice == 2);
            }
            // Tags of other meaning.
            _ => {}
        }
    }
    Ok(list)
}

impl CreaseList {
    /// Whether there is nothing in it.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.edges.is_empty() && self.vertices.is_empty()
    }

    /// Puts the sharpness onto a topology.
    ///
    /// # Errors
    /// Names the first edge or vertex that the mesh does not have.
    pub fn apply(&self, topology: &Topology, creases: &mut Creases) -> Result<(), String> {
        let count = topology.vertex_count();
        for &(ends, sharpness) in &self.edges {
            let edge = edge_between(topology, ends).ok_or_else(|| {
                format!("the mesh has no edge between vertices {} and {}", ends[0], ends[1])
            })?;
            creases.set_edge(edge, sharpness).map_err(|e| e.to_string())?;
        }
        for &(v, sharpness) in &self.vertices {
            if v as usize >= count {
                return Err(format!(
                    "vertex {v} is to be sharp, but the mesh has {count} vertices"
                ));
            }
            creases.set_vertex(VertexId(v), sharpness).map_err(|e| e.to_string())?;
        }
        Ok(())
    }
}

fn edge_between(topology: &Topology, [a, b]: [u32; 2]) -> Option<EdgeId> {
    if a as usize >= topology.vertex_count() {
        return None;
    }
    topology.fan(VertexId(a)).find_map(|h| {
        let back = topology.prev(h);
        match b {
            b if topology.target(h).0 == b => Some(topology.edge(h)),
            b if topology.origin(back).0 == b => Some(topology.edge(back)),
            _ => None,
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_forms_say_the_same() {
        let obj = b"v 0 0 0\nt crease 3/1/0 0 1 2 2.5\nt corner 1/1/0 7 10 # tip\n\
            t interpolateboundary 1/0/0 2\n";
        let json = br#"{"creaseIndices": [0, 1, 2], "creaseLengths": [3],
            "creaseSharpnesses": [2.5], "cornerIndices": [7], "cornerSharpnesses": [10],
            "interpolateBoundary": "edgeAndCorner"}"#;
        let expected = CreaseList {
            edges: vec![([0, 1], 2.5), ([1, 2], 2.5)],
            vertices: vec![(7, 10.0)],
            keep_corners: Some(true),
        };
        assert_eq!(parse_creases(obj).unwrap(), expected);
        assert_eq!(parse_creases(json).unwrap(), expected);
    }

    #[test]
    fn bad_creases_name_their_place() {
        for (text, place, part) in [
            ("\nt crease 2/1/0 0 1\n", Place::Line(2), "crease"),
            ("t crease 2/1/0 0 x 3\n", Place::Line(1), "crease"),
            ("t crease 2/1/0 0 1 -3\n", Place::Line(1), "crease"),
            ("t crease\n", Place::Line(1), "counts"),
            ("t corner 99999999999999999999/1/0 0 1\n", Place::Line(1), "counts"),
            ("t interpolateboundary 1/0/0 7", Place::Line(1), "boundary"),
            ("{\n \"creaseIndices\": [0, 1, }", Place::Line(2), "expected"),
            (r#"{"creaseLengths": [3], "creaseSharpnesses": [1]}"#, Place::File, "crease 0"),
            (r#"{"cornerIndices": [3]}"#, Place::File, "corner"),
        ] {
            let error = parse_creases(text.as_bytes()).unwrap_err();
            assert_eq!(error.place, place, "{text}: {error}");
            assert!(error.to_string().contains(part), "{text}: {error}");
        }
    }

    #[test]
    fn creases_need_their_edges() {
        let cube = fairform::shapes::cube();
        let list = parse_creases(b"t crease 2/1/0 0 1 3\n").unwrap();
        let mut creases = Creases::smooth(cube.topology());
        list.apply(cube.topology(), &mut creases).unwrap();
        assert!(!creases.is_smooth());
        for bad in ["t crease 2/1/0 0 7 3\n", "t crease 2/1/0 77 0 3\n", "t corner 1/1/0 8 1\n"] {
            let list = parse_creases(bad.as_bytes()).unwrap();
            assert!(list.apply(cube.topology(), &mut creases).is_err(), "{bad}");
        }
    }
}
