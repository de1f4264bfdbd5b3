//! Stereolithography files, as text or binary.
//!
//! The format has no vertices, only triangles with three positions each; equal positions are made
//! one vertex, numbered as they first appear. Whether a file is text shows in its size and its
//! content, since many a binary one begins with "solid" too.
//!
//! A binary file with bytes behind the declared triangles is read, with a note, unless the bytes
//! are exactly more triangles: then the count is wrong, and that is an error.
//!
//! Source: 3D Systems, *Stereolithography Interface Specification*, 1989.

use std::io::Write;
use std::mem::replace;
use std::sync::atomic::{AtomicBool, Ordering};

use fairform::{Faces, Vec3};

use crate::data::{LabelBuilder, MeshData, WriteOptions, too_many_corners};
use crate::error::{Error, ParseError, Place};
use crate::format::left_out;
use crate::par;
use crate::stream::{Checked, Shape};
use crate::text::{NumberWriter, ROWS, Scanner, counted, text_of};
use crate::triangulate::Triangles;
use crate::weld::{Point, Weld, numbers};

/// Bytes before the first triangle of a binary file: a free header, and the count.
const HEADER: usize = 84;
/// Bytes of a triangle: normal, three positions, two bytes of attributes.
const TRIANGLE: usize = 50;

/// The mesh in an STL file, a text read in so many parts.
pub(crate) fn parse(bytes: &[u8], part_count: usize) -> Result<MeshData, ParseError> {
    if is_text(bytes) { parse_text(bytes, part_count, BLOCK) } else { parse_binary(bytes, BLOCK) }
}

/// The number of triangles that a binary file declares.
fn declared(bytes: &[u8]) -> Option<u32> {
    Some(u32::from_le_bytes(*bytes.get(80..HEADER)?.as_array()?))
}

fn is_text(bytes: &[u8]) -> bool {
    let fits = |n: u32| HEADER as u64 + TRIANGLE as u64 * u64::from(n) == bytes.len() as u64;
    if declared(bytes).is_some_and(fits) {
        return false;
    }
    let Ok(mut text) = Scanner::new(bytes) else {
        return true;
    };
    text.skip_space();
    if !text.word().eq_ignore_ascii_case(b"solid") {
        // A text that is none of ours is better complained about as a text.
        return !bytes.contains(&0) && bytes.len() < HEADER;
    }
    text.skip_line();
    text.skip_space();
    let word = text.word();
    word.eq_ignore_ascii_case(b"facet")
        || word.eq_ignore_ascii_case(b"endsolid")
        || !bytes[..bytes.len().min(512)].contains(&0)
}

/// Triangles that stand one behind the other in a file, welded among themselves.
struct Part<P> {
    weld: Weld<P>,
    corners: Vec<u32>,
}

impl<P: Point> Part<P> {
    fn with_capacity(triangles: usize) -> Self {
        // A closed mesh has half as many vertices as triangles, a part of it a few more.
        let weld = Weld::with_capacity(triangles * 3 / 4);
        Self { weld, corners: Vec::with_capacity(3 * triangles) }
    }

    fn push(&mut self, triangle: [P; 3]) {
        self.corners.extend(triangle.map(|p| self.weld.vertex(p)));
    }
}

/// The mesh of all parts: a vertex has the number in which it first appears in the file.
fn join<P: Point + Send + Sync>(parts: &[Part<P>]) -> MeshData {
    let points: Vec<P> = parts.iter().flat_map(|part| &part.weld.positions).copied().collect();
    let numbers = numbers(&points);
    let vertex_count = numbers.iter().max().map_or(0, |last| *last as usize + 1);
    let corner_count = parts.iter().map(|part| part.corners.len()).sum();
    let mut positions: Vec<Vec3> = bytemuck::zeroed_vec(vertex_count);
    let mut corners: Vec<u32> = bytemuck::zeroed_vec(corner_count);
    let mut tasks = Vec::new();
    let (mut rest, mut corners_left) = (positions.as_mut_slice(), corners.as_mut_slice());
    let mut numbers_left = numbers.as_slice();
    let mut first_new = 0;
    for part in parts {
        let own = numbers_left.split_off(..part.weld.positions.len()).unwrap_or_default();
        let corners = corners_left.split_off_mut(..part.corners.len()).unwrap_or_default();
        let new = own.iter().filter(|number| **number >= first_new).count();
        let new_positions = rest.split_off_mut(..new).unwrap_or_default();
        tasks.push((part, own, corners, new_positions, first_new));
        first_new += new as u32;
    }
    let flat: usize = par::map(tasks, |(part, own, corners, new_positions, first_new)| {
        let new = own.iter().zip(&part.weld.positions).filter(|(number, _)| **number >= first_new);
        for (slot, (_, position)) in new_positions.iter_mut().zip(new) {
            *slot = position.position();
        }
        for (corner, local) in corners.iter_mut().zip(&part.corners) {
            *corner = own[*local as usize];
        }
        let is_flat = |[a, b, c]: &&[u32; 3]| a == b || b == c || c == a;
        corners.as_chunks::<3>().0.iter().filter(is_flat).count()
    })
    .into_iter()
    .sum();

    let mut notes = Vec::new();
    if !corners.is_empty() {
        let vertices = counted(positions.len(), "vertex");
        let corners = counted(corners.len(), "corner");
        notes.push(format!("welded {corners} into {vertices}: STL has no connectivity"));
    }
    if flat > 0 {
        let n = counted(flat, "triangle");
        notes.push(format!("{n} with two corners at one point kept"));
    }
    let faces = Faces::uniform(3, corners);
    MeshData { positions, faces, notes, ..MeshData::default() }
}

/// Fails for more triangles than corners can be counted, at the place of the first too many.
fn check_count(count: usize, place: impl Fn(usize) -> Place) -> Result<(), ParseError> {
    const MOST: usize = u32::MAX as usize / 3;
    if count <= MOST { Ok(()) } else { Err(too_many_corners(place(MOST))) }
}

/// Triangles that are welded at once, in the processor's own memory.
const BLOCK: usize = 1 << 15;

/// Reads a binary file, in parts of `block` triangles.
fn parse_binary(bytes: &[u8], block: usize) -> Result<MeshData, ParseError> {
    let Some(count) = declared(bytes) else {
        let n = counted(bytes.len(), "byte");
        return Err(ParseError::file(format!("the file ends after {n}"))
            .expected("an STL text, or 84 bytes before the first triangle"));
    };
    let body = &bytes[HEADER..];
    let room = body.len() / TRIANGLE;
    let count = count as usize;
    if count > room {
        let message = format!("the file declares {count} triangles and ends after {room}");
        return Err(ParseError::byte(bytes.len(), message));
    }
    let behind = body.len() - count * TRIANGLE;
    if behind > 0 && behind.is_multiple_of(TRIANGLE) {
        let message = format!("the file declares {count} triangles, but holds exactly {room}");
        return Err(ParseError::byte(80, message));
    }
    check_count(count, |i| Place::Byte((HEADER + i * TRIANGLE) as u64))?;
    let triangles = &body.as_chunks::<TRIANGLE>().0[..count];
    let (parts, attributes): (Vec<_>, Vec<_>) =
        par::map(triangles.chunks(block), read_triangles).into_iter().unzip();
    let mut data = join(&parts);
    let attributes: usize = attributes.into_iter().sum();
    if attributes > 0 {
        let n = counted(attributes, "triangle");
        data.notes.push(format!("attribute bytes (colours) of {n} left out"));
    }
    if behind > 0 {
        let n = counted(behind, "byte");
        data.notes.push(format!("{n} behind the last triangle unread"));
    }
    Ok(data)
}

/// The triangles, and how many have attributes.
fn read_triangles(triangles: &[[u8; TRIANGLE]]) -> (Part<[f32; 3]>, usize) {
    let mut part = Part::with_capacity(triangles.len());
    let mut attributes = 0;
    for triangle in triangles {
        let words = triangle.as_chunks::<4>().0;
        let number = |at: usize| f32::from_le_bytes(words[at]);
        let point = |at: usize| [number(at), number(at + 1), number(at + 2)];
        part.push([point(3), point(6), point(9)]);
        attributes += usize::from(triangle[48..] != [0, 0]);
    }
    (part, attributes)
}

/// Reads a text in so many parts, which begin with a facet, and welds `block` triangles at once. A text
/// with a fault is read again as a whole, so that its error is that of a reader that sees all before.
fn parse_text(bytes: &[u8], part_count: usize, block: usize) -> Result<MeshData, ParseError> {
    let text = Scanner::new(bytes)?;
    let parts = text.parts(part_count, begins_facet);
    if parts.len() > 1 {
        let within = |i: usize| [i > 0, i + 1 < parts.len()];
        let facets =
            par::map(parts.iter().enumerate(), |(i, part)| Facets::read(*part, within(i), block));
        if let Ok(facets) = facets.into_iter().collect::<Result<Vec<_>, _>>() {
            return mesh_of(&text, facets);
        }
    }
    mesh_of(&text, vec![Facets::read(text, [false; 2], block)?])
}

/// Whether what is behind a line end begins with a facet.
fn begins_facet(_: &[u8], rest: &[u8]) -> bool {
    peek_is(&Scanner { bytes: rest, at: 0 }, "facet")
}

/// What stands in a text, or in a part of one.
struct Facets {
    parts: Vec<Part<Vec3>>,
    /// Where the names of solids are, and how many facets of the part stand before.
    solids: Vec<(usize, usize)>,
}

impl Facets {
    /// Reads all facets. Whether the text begins and ends within a solid is given; another end is an
    /// error.
    fn read(
        mut text: Scanner<'_>,
        [begins_within, ends_within]: [bool; 2],
        block: usize,
    ) -> Result<Self, ParseError> {
        let mut facets = Self { parts: Vec::new(), solids: Vec::new() };
        // An estimate: a facet takes some 200 bytes.
        let room = (text.remaining() / 200).min(block);
        let mut part = Part::with_capacity(room);
        let mut count = 0;
        let mut within = begins_within;
        loop {
            text.skip_space();
            if !within {
                if text.is_at_end() {
                    break;
                }
                keyword(&mut text, "solid")?;
                facets.solids.push((text.at, count));
                text.skip_line();
                within = true;
            } else if peek_is(&text, "facet") {
                part.push(facet(&mut text)?);
                count += 1;
                if count.is_multiple_of(block) {
                    facets.parts.push(replace(&mut part, Part::with_capacity(room)));
                }
            } else if text.is_at_end() {
                break;
            } else {
                keyword(&mut text, "endsolid")?;
                // The name again.
                text.skip_line();
                within = false;
            }
        }
        if within != ends_within {
            return Err(ended(&text, "a solid"));
        }
        facets.parts.push(part);
        Ok(facets)
    }

    fn len(&self) -> usize {
        self.parts.iter().map(|part| part.corners.len() / 3).sum()
    }
}

/// The mesh of all facets of a text.
fn mesh_of(text: &Scanner<'_>, facets: Vec<Facets>) -> Result<MeshData, ParseError> {
    let count = facets.iter().map(Facets::len).sum();
    check_count(count, |_| Place::File)?;
    let mut groups = LabelBuilder::default();
    let (mut before, mut solids) = (0, 0);
    for part in &facets {
        for &(at, facet) in &part.solids {
            groups.fill(before + facet);
            groups.set(text_of(Scanner { at, ..*text }.rest_of_line()));
            solids += 1;
        }
        before += part.len();
    }
    groups.fill(count);
    let parts: Vec<_> = facets.into_iter().flat_map(|part| part.parts).collect();
    let mut data = join(&parts);
    if solids > 1 {
        data.groups = groups.finish();
    }
    Ok(data)
}

fn ended(text: &Scanner<'_>, within: &str) -> ParseError {
    text.error(format!("the file ends within {within}"))
}

fn peek_is(text: &Scanner<'_>, expected: &str) -> bool {
    let mut text = *text;
    text.word().eq_ignore_ascii_case(expected.as_bytes())
}

/// Reads one word that must be there, in any case.
fn keyword(text: &mut Scanner<'_>, expected: &str) -> Result<(), ParseError> {
    text.skip_space();
    let start = *text;
    if text.word().eq_ignore_ascii_case(expected.as_bytes()) {
        return Ok(());
    }
    Err(start.unexpected(expected))
}

/// Reads `facet … outer loop`, three vertices, and what ends them. The normal is not needed.
fn facet(text: &mut Scanner<'_>) -> Result<[Vec3; 3], ParseError> {
    let mut read = || -> Result<[Vec3; 3], ParseError> {
        keyword(text, "facet")?;
        text.skip_space();
        while !peek_is(text, "outer") {
            if text.word().is_empty() {
                return Err(text.unexpected("outer loop"));
            }
            text.skip_space();
        }
        keyword(text, "outer")?;
        keyword(text, "loop")?;
        let mut triangle = [Vec3::ZERO; 3];
        for corner in &mut triangle {
            keyword(text, "vertex")?;
            let mut position = [0.0; 3];
            for x in &mut position {
                text.skip_space();
                *x = text.number()?;
            }
            *corner = position.into();
        }
        keyword(text, "endloop")?;
        keyword(text, "endfacet")?;
        Ok(triangle)
    };
    read().map_err(|error| if text.is_at_end() { ended(text, "a facet") } else { error })
}

/// Writes an STL file: binary with one header, or text with a solid per run of a group.
pub(crate) fn encode(
    data: &MeshData,
    options: &WriteOptions,
    out: &mut dyn Write,
) -> Result<Vec<String>, Error> {
    let triangles = Triangles::new(&data.positions, &data.faces);
    let used = used(data);
    let unused = used.iter().filter(|used| !**used).count();
    let shape = Shape { unused, ..Shape::of(data) };
    if options.ascii {
        write_text(data, options, &triangles, out)?;
    } else {
        write_binary(data, &triangles.corners, out)?;
    }
    let blocks = data.positions.chunks(ROWS).zip(used.chunks(ROWS));
    let rounded = par::map(blocks, |(positions, used)| {
        positions.iter().zip(used).any(|(p, used)| *used && !are_single(&[*p]))
    });
    let rounded = !options.ascii && rounded.contains(&true);
    Ok(notes(&shape, options, rounded, [triangles.cut, triangles.dropped]))
}

/// As [`encode`], of a mesh that is made meanwhile.
pub(crate) fn encode_blocks(
    blocks: &Checked<'_>,
    options: &WriteOptions,
    out: &mut dyn Write,
) -> Result<Vec<String>, Error> {
    let shape = &blocks.shape;
    let rounded = AtomicBool::new(false);
    if options.ascii {
        // There are no groups.
        out.write_all(b"solid fairform\n")?;
        blocks.write_patches(out, |patch, out| {
            let mut numbers = NumberWriter::new(options.single_precision);
            for &triangle in &*Triangles::new(&patch.positions, &patch.faces).corners {
                text_row(corners_of(&patch.positions, triangle), &mut numbers, out);
            }
        })?;
        out.write_all(b"endsolid fairform\n")?;
    } else {
        let triangles = shape.face_count.saturating_mul(shape.face_size.saturating_sub(2));
        write_binary_header(triangles, out)?;
        blocks.write_patches(out, |patch, out| {
            if !are_single(&patch.positions) {
                rounded.store(true, Ordering::Relaxed);
            }
            let triangles = Triangles::new(&patch.positions, &patch.faces);
            binary_rows(&patch.positions, &triangles.corners, out);
        })?;
    }
    let cut = if shape.face_size > 3 { shape.face_count } else { 0 };
    Ok(notes(shape, options, rounded.into_inner(), [cut, 0]))
}

fn notes(
    shape: &Shape<'_>,
    options: &WriteOptions,
    rounded: bool,
    [cut, dropped]: [usize; 2],
) -> Vec<String> {
    let mut notes: Vec<String> = rounded.then(rounding_note).into_iter().collect();
    notes.extend(triangle_notes(cut, dropped));
    if shape.unused > 0 {
        notes.push(format!("{} of no face left out", counted(shape.unused, "vertex")));
    }
    notes.extend(left_out(
        &[
            (shape.creases, "crease tags"),
            (shape.normals || shape.corner_normals, "normals of vertices"),
            (shape.colours, "colours"),
            (shape.uvs || shape.corner_uvs, "texture coordinates"),
            (shape.groups.is_some() && !options.ascii, "groups"),
            (shape.materials.is_some(), "materials"),
            (shape.material_library.is_some(), "the material library"),
        ],
        "STL",
    ));
    notes
}

/// Says how many polygons became triangles, and how many faces were none.
pub(crate) fn triangle_notes(cut: usize, dropped: usize) -> Vec<String> {
    let mut notes = Vec::new();
    if cut > 0 {
        notes.push(format!("{} cut into triangles", counted(cut, "polygon")));
    }
    if dropped > 0 {
        notes.push(format!("{} with fewer than 3 corners left out", counted(dropped, "face")));
    }
    notes
}

/// Says that coordinates are not the same in 32 bits.
pub(crate) fn rounding_note() -> String {
    "coordinates rounded to 32 bits".into()
}

/// Whether coordinates are the same in 32 bits.
pub(crate) fn are_single(positions: &[Vec3]) -> bool {
    let exact = |x: f64| x.is_nan() || f64::from(x as f32).to_bits() == x.to_bits();
    positions.iter().all(|p| exact(p.x) && exact(p.y) && exact(p.z))
}

/// Whether each vertex belongs to a face.
fn used(data: &MeshData) -> Vec<bool> {
    let mut used = vec![false; data.positions.len()];
    data.faces.corners().iter().for_each(|v| used[*v as usize] = true);
    used
}

fn corners_of(positions: &[Vec3], triangle: [u32; 3]) -> ([Vec3; 3], Vec3) {
    let [a, b, c] = triangle.map(|v| positions[v as usize]);
    ([a, b, c], (b - a).cross(c - a).normalized())
}

fn write_binary(data: &MeshData, triangles: &[[u32; 3]], out: &mut dyn Write) -> Result<(), Error> {
    write_binary_header(triangles.len(), out)?;
    par::write_rows(out, triangles.len(), ROWS, |rows, out| {
        binary_rows(&data.positions, &triangles[rows], out);
    })?;
    Ok(())
}

fn write_binary_header(triangles: usize, out: &mut dyn Write) -> Result<(), Error> {
    let Ok(count) = u32::try_from(triangles) else {
        return Err(Error::Unwritable(format!("{triangles} triangles are too many")));
    };
    // Not "solid", so that nobody takes the file for a text.
    let mut header = [0; HEADER];
    header[..8].copy_from_slice(b"fairform");
    header[80..].copy_from_slice(&count.to_le_bytes());
    out.write_all(&header)?;
    Ok(())
}

/// Appends the records of some triangles.
fn binary_rows(positions: &[Vec3], triangles: &[[u32; 3]], out: &mut Vec<u8>) {
    for &triangle in triangles {
        let ([a, b, c], normal) = corners_of(positions, triangle);
        let mut record = [0; TRIANGLE];
        for (bytes, v) in record.as_chunks_mut::<12>().0.iter_mut().zip([normal, a, b, c]) {
            bytes[..4].copy_from_slice(&(v.x as f32).to_le_bytes());
            bytes[4..8].copy_from_slice(&(v.y as f32).to_le_bytes());
            bytes[8..].copy_from_slice(&(v.z as f32).to_le_bytes());
        }
        out.extend_from_slice(&record);
    }
}

fn write_text(
    data: &MeshData,
    options: &WriteOptions,
    triangles: &Triangles<'_>,
    out: &mut dyn Write,
) -> Result<(), Error> {
    let count = triangles.corners.len();
    let name = |triangle: Option<usize>| {
        let label = data.groups.as_ref().zip(triangle);
        label.map_or_else(
            || "fairform".to_string(),
            |(groups, triangle)| {
                let name = &groups.names[groups.of_face[triangles.face_of(triangle)] as usize];
                name.replace(|c: char| c.is_control(), " ").trim().to_string()
            },
        )
    };
    let last = count.checked_sub(1);
    writeln!(out, "solid {}", name(last.map(|_| 0)))?;
    par::write_rows(out, count, ROWS, |rows, out| {
        let mut numbers = NumberWriter::new(options.single_precision);
        for i in rows {
            let label = |i| data.groups.as_ref().map(|g| g.of_face[triangles.face_of(i)]);
            if i > 0 && label(i) != label(i - 1) {
                let (before, next) = (name(Some(i - 1)), name(Some(i)));
                out.extend_from_slice(format!("endsolid {before}\nsolid {next}\n").as_bytes());
            }
            text_row(corners_of(&data.positions, triangles.corners[i]), &mut numbers, out);
        }
    })?;
    writeln!(out, "endsolid {}", name(last))?;
    Ok(())
}

/// Appends a facet.
fn text_row((corners, normal): ([Vec3; 3], Vec3), numbers: &mut NumberWriter, out: &mut Vec<u8>) {
    out.extend_from_slice(b"  facet normal");
    numbers.write_all(out, &<[f64; 3]>::from(normal));
    out.extend_from_slice(b"\n    outer loop\n");
    for p in corners {
        out.extend_from_slice(b"      vertex");
        numbers.write_all(out, &<[f64; 3]>::from(p));
        out.push(b'\n');
    }
    out.extend_from_slice(b"    endloop\n  endfacet\n");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_welded_as_the_whole() {
        let mesh = fairform::shapes::torus(8, 9);
        let faces = Faces::uniform(
            3,
            mesh.topology().halfedges().map(|h| mesh.topology().origin(h).0).collect(),
        );
        let data = MeshData { positions: mesh.positions().to_vec(), faces, ..MeshData::default() };
        let mut bytes = Vec::new();
        encode(&data, &WriteOptions::default(), &mut bytes).unwrap();
        // A flat triangle, and one with attributes.
        let (first, second) = (HEADER + 12, HEADER + TRIANGLE);
        bytes.copy_within(first..first + 12, first + 12);
        bytes[second + 48] = 1;
        let whole = parse_binary(&bytes, usize::MAX).unwrap();
        assert_eq!(whole.positions.len(), 72);
        assert_eq!(whole.notes.len(), 3, "{:?}", whole.notes);
        for block in [1, 2, 7, 100] {
            assert_eq!(parse_binary(&bytes, block).unwrap(), whole);
        }
    }

    #[test]
    fn a_text_is_read_in_parts_and_blocks() {
        let facet = |x: usize| {
            format!(
                "facet normal 0 0 1\nouter loop\nvertex {x} 0 0\nvertex 0 {x} 0\n\
                vertex 0 0 1\nendloop\nendfacet\n"
            )
        };
        let facets: String = (0..9).map(facet).collect();
        let text = format!(
            "solid a\n{facets}endsolid a\nsolid\nendsolid\nSOLID b\n{facets}\n \
            FACET normal 0 0 1 outer loop vertex\n1 1 1 vertex 2\n2 2 vertex 3 3 3 endloop endfacet\n\
            {facets}endsolid facet\n"
        );
        let whole = parse_text(text.as_bytes(), 1, usize::MAX).unwrap();
        assert_eq!((whole.positions.len(), whole.faces.len()), (21, 28));
        assert_eq!(whole.groups.as_ref().unwrap().names, ["a", "b"]);
        for (parts, block) in [(1, 1), (1, 4), (2, 3), (3, 1), (9, 2), (1000, 100)] {
            assert_eq!(parse_text(text.as_bytes(), parts, block).as_ref(), Ok(&whole));
        }
        // Cut at every facet, each but the last ends within a solid.
        let text = Scanner { bytes: text.as_bytes(), at: 0 };
        let parts = text.parts(1000, begins_facet);
        assert_eq!(parts.len(), 29);
        assert!(parts[1..28].iter().all(|part| Facets::read(*part, [true; 2], 9).is_ok()));
        assert!(Facets::read(parts[28], [true; 2], 9).is_err());
        assert_eq!(Facets::read(parts[28], [true, false], 9).unwrap().len(), 1);
    }
}
