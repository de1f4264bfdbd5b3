//! Sharp edges and vertices: the tags of OpenSubdiv's OBJ shapes, and JSON as in USD.

use std::io::{self, Write};

use fairform::topology::Topology;
use fairform::{Border, Corners, Creases, EdgeId, FaceId, NONE, Rules, Scheme, VertexId};
use serde::Deserialize;

use crate::error::{ParseError, Place};
use crate::par;
use crate::text::{NumberWriter, ROWS};

/// What a file says about a subdivision surface besides its mesh: sharp edges and vertices by number,
/// holes, the boundary.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct CreaseList {
    /// Ends and sharpness of edges.
    pub edges: Vec<([u32; 2], f64)>,
    /// Sharp vertices.
    pub vertices: Vec<(u32, f64)>,
    /// Faces that support the surface around them but have none themselves.
    pub holes: Vec<u32>,
    /// What becomes of the boundary, if the file says.
    pub boundary: Option<InterpolateBoundary>,
}

/// What becomes of the boundary. The names are those of USD and OpenSubdiv.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum InterpolateBoundary {
    /// Faces at the boundary are support: no surface corresponds to them.
    None,
    /// The boundary is a curve that rounds its corners.
    EdgeOnly,
    /// The boundary is a curve that keeps its corners.
    EdgeAndCorner,
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
    #[serde(default)]
    hole_indices: Vec<u32>,
    interpolate_boundary: Option<String>,
}

/// Reads creases: JSON if the text begins with a brace, otherwise the `t` lines of an OBJ file.
///
/// JSON has the fields of a USD mesh: `creaseIndices`, `creaseLengths`, `creaseSharpnesses` (one per
/// crease, or one per edge), `cornerIndices`, `cornerSharpnesses`, `holeIndices`, `interpolateBoundary`
/// (`none`, `edgeOnly`, `edgeAndCorner`). OBJ has lines such as `t crease 2/1/0 0 1 4.0`,
/// `t corner 1/1/0 7 10`, `t hole 1/0/0 5` and `t interpolateboundary 1/0/0 2` (0 none, 1 edge and corner,
/// 2 edge only), with vertices and faces counted from 0. A crease tag lists pairs of vertices; an odd
/// number of them is a chain. Other tags are passed over.
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
    list.holes = json.hole_indices;
    list.boundary = match json.interpolate_boundary.as_deref() {
        None => None,
        Some("none") => Some(InterpolateBoundary::None),
        Some("edgeAndCorner") => Some(InterpolateBoundary::EdgeAndCorner),
        Some("edgeOnly") => Some(InterpolateBoundary::EdgeOnly),
        Some(other) => {
            let message = format!("interpolateBoundary is {other:?}");
            return Err(wrong(Place::File, message, "none, edgeOnly or edgeAndCorner"));
        }
    };
    Ok(list)
}

fn obj(text: &str) -> Result<CreaseList, ParseError> {
    let mut list = CreaseList::default();
    for (number, line) in (1..).zip(text.lines()) {
        let line = line.split('#').next().unwrap_or_default().trim_start();
        if let Some(rest) = line.strip_prefix("t").filter(|r| r.starts_with([' ', '\t'])) {
            list.add_tag(rest, Place::Line(number))?;
        }
    }
    Ok(list)
}

impl CreaseList {
    /// Whether nothing is sharp and nothing a hole.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.edges.is_empty() && self.vertices.is_empty() && self.holes.is_empty()
    }

    /// What the sharpness on a topology, and a choice about the boundary, look like in a file.
    #[must_use]
    pub fn of(
        topology: &Topology,
        creases: Option<&Creases>,
        boundary: Option<InterpolateBoundary>,
    ) -> Self {
        let mut list = Self { boundary, ..Self::default() };
        let Some(creases) = creases else { return list };
        for e in topology.edges().filter(|&e| creases.edge(e) > 0.0) {
            let h = topology.edge_halfedge(e);
            let ends = [topology.origin(h).0, topology.target(h).0];
            list.edges.push((ends, creases.edge(e)));
        }
        let sharp = topology.vertices().filter(|&v| creases.vertex(v) > 0.0);
        list.vertices = sharp.map(|v| (v.0, creases.vertex(v))).collect();
        list
    }

    /// What makes the surface of a control mesh: sharpness, the boundary, and as holes the faces for which
    /// there could be a surface but is not shown. `None` if it makes none, or the scheme knows no creases.
    ///
    /// `is_tagged` says whether the choice about the boundary was made by tags, and so is worth telling.
    #[must_use]
    pub fn of_control(
        topology: &Topology,
        rules: &Rules,
        is_tagged: bool,
        is_shown: impl Fn(FaceId) -> bool,
    ) -> Option<Self> {
        if !matches!(rules.scheme, Scheme::Loop | Scheme::CatmullClark) {
            return None;
        }
        let said = match (rules.border, rules.corners) {
            (Border::None, _) => Some(InterpolateBoundary::None),
            (_, Corners::Sharp) => Some(InterpolateBoundary::EdgeAndCorner),
            _ => is_tagged.then_some(InterpolateBoundary::EdgeOnly),
        };
        let mut list = Self::of(topology, rules.creases.as_deref(), said);
        // A face at a boundary without surface is no hole.
        let can_show = rules.has_surface(topology);
        let holes = topology.faces().filter(|&f| can_show[f.index()] && !is_shown(f));
        list.holes = holes.map(|f| f.0).collect();
        (!list.is_empty() || list.boundary.is_some()).then_some(list)
    }

    /// Takes what follows the `t` of a tag. Tells the name of one that has another meaning.
    pub(crate) fn add_tag<'t>(
        &mut self,
        rest: &'t str,
        place: Place,
    ) -> Result<Option<&'t str>, ParseError> {
        let mut words = rest.split_whitespace();
        let name = words.next().unwrap_or_default();
        let counts = words.next().and_then(|counts| {
            let mut counts = counts.split('/').map(|n| n.parse::<usize>().ok());
            Some([counts.next()??, counts.next()??])
        });
        let Some([ints, floats]) = counts else {
            return Err(wrong(place, "a tag without counts", "t NAME INTS/FLOATS/STRINGS …"));
        };
        let values: Vec<&str> = words.collect();
        let bad = |what: &str, expected: &str| Err(wrong(place, what, expected));
        if ints.checked_add(floats).is_none_or(|n| n > values.len()) {
            return bad(&format!("a {name} tag with too few values"), "as many as it counts");
        }
        let numbers = values[..ints].iter().map(|w| w.parse::<u32>().ok().filter(|v| *v < NONE));
        let numbers: Option<Vec<u32>> = numbers.collect();
        let sharpness = values[ints..ints + floats]
            .iter()
            .map(|w| w.parse::<f64>().ok().filter(|s| *s >= 0.0))
            .collect::<Option<Vec<f64>>>();
        match (name, numbers, sharpness) {
            ("crease", Some(ends), Some(sharpness)) if ends.len() >= 2 => {
                let step = if ends.len().is_multiple_of(2) { 2 } else { 1 };
                let pairs = ends.windows(2).step_by(step).map(|w| [w[0], w[1]]);
                match sharpness.as_slice() {
                    &[one] => self.edges.extend(pairs.map(|pair| (pair, one))),
                    each if each.len() == pairs.len() => {
                        self.edges.extend(pairs.zip(each.iter().copied()));
                    }
                    _ => return bad("a bad crease", "one sharpness, or one per edge"),
                }
            }
            ("crease", ..) => return bad("a bad crease", "t crease 2/1/0 VERTEX VERTEX SHARPNESS"),
            ("corner", Some(corners), Some(sharpness)) if !corners.is_empty() => {
                match sharpness.as_slice() {
                    &[one] => self.vertices.extend(corners.into_iter().map(|v| (v, one))),
                    each if each.len() == corners.len() => {
                        self.vertices.extend(corners.into_iter().zip(each.iter().copied()));
                    }
                    _ => return bad("a bad corner", "one sharpness, or one per vertex"),
                }
            }
            ("corner", ..) => return bad("a bad corner", "t corner 1/1/0 VERTEX SHARPNESS"),
            ("hole", Some(faces), _) => self.holes.extend(faces),
            ("hole", ..) => return bad("a bad hole", "t hole 1/0/0 FACE"),
            ("interpolateboundary", choice, _) => {
                self.boundary = Some(match choice.as_deref() {
                    Some([0]) => InterpolateBoundary::None,
                    Some([1]) => InterpolateBoundary::EdgeAndCorner,
                    Some([2]) => InterpolateBoundary::EdgeOnly,
                    _ => {
                        let expected = "0 (none), 1 (edges and corners) or 2 (edges)";
                        return bad("a bad boundary choice", expected);
                    }
                });
            }
            (other, ..) => return Ok(Some(other)),
        }
        Ok(None)
    }

    /// Writes the tags of an OBJ file.
    pub(crate) fn write_tags(&self, single: bool, out: &mut dyn Write) -> io::Result<()> {
        par::write_rows(out, self.edges.len(), ROWS, |rows, out| {
            let mut numbers = NumberWriter::new(single);
            for &(ends, sharpness) in &self.edges[rows] {
                out.extend_from_slice(b"t crease 2/1/0");
                for end in ends {
                    out.push(b' ');
                    numbers.whole(out, end.into());
                }
                numbers.write_all(out, &[sharpness]);
                out.push(b'\n');
            }
        })?;
        par::write_rows(out, self.vertices.len(), ROWS, |rows, out| {
            let mut numbers = NumberWriter::new(single);
            for &(v, sharpness) in &self.vertices[rows] {
                out.extend_from_slice(b"t corner 1/1/0 ");
                numbers.whole(out, v.into());
                numbers.write_all(out, &[sharpness]);
                out.push(b'\n');
            }
        })?;
        for face in &self.holes {
            writeln!(out, "t hole 1/0/0 {face}")?;
        }
        if let Some(boundary) = self.boundary {
            let number = match boundary {
                InterpolateBoundary::None => 0,
                InterpolateBoundary::EdgeOnly => 2,
                InterpolateBoundary::EdgeAndCorner => 1,
            };
            writeln!(out, "t interpolateboundary 1/0/0 {number}")?;
        }
        Ok(())
    }

    /// Puts the sharpness onto a topology.
    ///
    /// # Errors
    /// Names the first edge, vertex or face that the mesh does not have.
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
        if let Some(f) = self.holes.iter().find(|f| **f as usize >= topology.face_count()) {
            let count = topology.face_count();
            return Err(format!("face {f} is to be a hole, but the mesh has {count} faces"));
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
            t hole 2/0/0 3 4\nt interpolateboundary 1/0/0 1\nt creasemethod 0/0/1 chaikin\n";
        let json = br#"{"creaseIndices": [0, 1, 2], "creaseLengths": [3],
            "creaseSharpnesses": [2.5], "cornerIndices": [7], "cornerSharpnesses": [10],
            "holeIndices": [3, 4], "interpolateBoundary": "edgeAndCorner"}"#;
        let expected = CreaseList {
            edges: vec![([0, 1], 2.5), ([1, 2], 2.5)],
            vertices: vec![(7, 10.0)],
            holes: vec![3, 4],
            boundary: Some(InterpolateBoundary::EdgeAndCorner),
        };
        assert_eq!(parse_creases(obj).unwrap(), expected);
        assert_eq!(parse_creases(json).unwrap(), expected);
    }

    /// The numbers are those of OpenSubdiv's `shape_utils.h`, the names those of USD.
    #[test]
    fn boundaries_have_numbers_and_names() {
        for (number, name, choice) in [
            (0, "none", InterpolateBoundary::None),
            (1, "edgeAndCorner", InterpolateBoundary::EdgeAndCorner),
            (2, "edgeOnly", InterpolateBoundary::EdgeOnly),
        ] {
            let obj = format!("t interpolateboundary 1/0/0 {number}\n");
            let json = format!("{{\"interpolateBoundary\": \"{name}\"}}");
            for text in [obj, json] {
                assert_eq!(parse_creases(text.as_bytes()).unwrap().boundary, Some(choice));
            }
        }
    }

    #[test]
    fn creases_are_pairs_or_chains() {
        let edges = |text: &str| parse_creases(text.as_bytes()).unwrap().edges;
        let pairs = vec![([0, 1], 2.0), ([4, 5], 3.0)];
        assert_eq!(edges("t crease 4/2/0 0 1 4 5 2 3\n"), pairs);
        assert_eq!(edges("t crease 3/2/0 0 1 2 2 3\n"), [([0, 1], 2.0), ([1, 2], 3.0)]);
    }

    #[test]
    fn bad_creases_name_their_place() {
        for (text, place, part) in [
            ("\nt crease 2/1/0 0 1\n", Place::Line(2), "crease"),
            ("t crease 2/1/0 0 x 3\n", Place::Line(1), "crease"),
            ("t crease 2/1/0 0 1 -3\n", Place::Line(1), "crease"),
            ("t crease\n", Place::Line(1), "counts"),
            ("t corner 99999999999999999999/1/0 0 1\n", Place::Line(1), "counts"),
            ("t corner 9223372036854775807/9223372036854775807/0 0 1\n", Place::Line(1), "few"),
            ("t crease 4/3/0 0 1 2 3 1 1 1\n", Place::Line(1), "per edge"),
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
        for bad in [
            "t crease 2/1/0 0 7 3\n",
            "t crease 2/1/0 77 0 3\n",
            "t corner 1/1/0 8 1\n",
            "t hole 1/0/0 6\n",
        ] {
            let list = parse_creases(bad.as_bytes()).unwrap();
            assert!(list.apply(cube.topology(), &mut creases).is_err(), "{bad}");
        }
    }
}
