//! Wavefront OBJ.
//!
//! Read: `v` with weight or colour, `vt`, `vn`, `f` in all index forms, `o`, `g`, `usemtl`,
//! `mtllib`, and the `t` tags of OpenSubdiv's shapes, where vertices and faces count from 0. Points, lines, smoothing groups and free-form geometry are counted and left out.
//! Comments may stand anywhere, a backslash continues a line, lines end with LF, CR or CRLF.
//!
//! Source: Wavefront Technologies, *Advanced Visualizer manual*, appendix B1, 1995; colours behind
//! the coordinates as `MeshLab` and others write them.

use std::collections::HashMap;
use std::io::Write;
use std::mem::take;
use std::ops::Range;

use fairform::{FaceId, Faces, NONE, Vec3};

use crate::crease::CreaseList;
use crate::data::{
    LabelBuilder, Labels, MeshData, WriteOptions, scale_large_colours, too_many_corners,
};
use crate::error::{Error, ParseError, Place};
use crate::format::left_out;
use crate::par;
use crate::stream::{Attributes, Checked};
use crate::text::{NumberWriter, ROWS, Scanner, counted, quoted};

/// The mesh in an OBJ file, read in so many parts, which end with a statement. A file with a fault is
/// read again as a whole, so that its errors and notes are those of one reader that sees all before.
pub(crate) fn parse(bytes: &[u8], part_count: usize) -> Result<MeshData, ParseError> {
    let text = Scanner::new(bytes)?;
    let parts = text.parts(part_count, ends_statement);
    if parts.len() > 1 {
        let parts = par::map(parts, |part| Reader::new(part, true).statements());
        let joined = parts.into_iter().collect::<Result<_, _>>().ok().and_then(Reader::joined);
        if let Some(data) = joined.and_then(|reader| Reader { text, ..reader }.finish().ok()) {
            return Ok(data);
        }
    }
    Reader::new(text, false).statements()?.finish()
}

/// Whether no backslash continues a text on the next line.
fn ends_statement(text: &[u8], _: &[u8]) -> bool {
    !text.strip_suffix(b"\r").unwrap_or(text).ends_with(b"\\")
}

/// Statements of the format that do not describe polygons.
const FREE_FORM: [&[u8]; 37] = [
    b"vp",
    b"cstype",
    b"deg",
    b"bmat",
    b"step",
    b"curv",
    b"curv2",
    b"surf",
    b"parm",
    b"trim",
    b"hole",
    b"scrv",
    b"sp",
    b"end",
    b"con",
    b"mg",
    b"bevel",
    b"c_interp",
    b"d_interp",
    b"lod",
    b"shadow_obj",
    b"trace_obj",
    b"ctech",
    b"stech",
    b"bsp",
    b"bzp",
    b"cdc",
    b"cdp",
    b"res",
    b"maplib",
    b"usemap",
    b"call",
    b"csh",
    b"cstech",
    b"ctype",
    b"scmp",
    b"sfv",
];

/// Indices into one kind of value (`v`, `vt` or `vn`).
#[derive(Default)]
struct Indices {
    /// Those beyond the values read so far, each larger than all before, with their offset: the
    /// first that stays out of range is among them. Not kept in a part of a file.
    ahead: Vec<(u32, usize)>,
    /// In a part of a file: what is known once the parts before are.
    part: Option<PartIndices>,
}

/// Indices of a part of a file, which does not know how many values stand before it.
#[derive(Default)]
struct PartIndices {
    /// One more than the largest that counts from the first value of the file.
    end: usize,
    /// How many values before the part are needed by those that count backwards.
    reach: usize,
    /// Corners whose indices count from the first value of the part, modulo 2³².
    relative: Vec<Range<usize>>,
}

impl PartIndices {
    fn resolve(&mut self, number: i64, count: usize, corner: usize) -> Option<u32> {
        if number > 0 {
            let index = u32::try_from(number - 1).ok().filter(|index| *index < NONE)?;
            self.end = self.end.max(index as usize + 1);
            return Some(index);
        }
        let index = number.checked_add(i64::try_from(count).ok()?).filter(|_| number < 0)?;
        let reach = u32::try_from(index.min(0).unsigned_abs()).ok()?;
        self.reach = self.reach.max(reach as usize);
        match self.relative.last_mut() {
            Some(last) if last.end == corner => last.end += 1,
            _ => self.relative.push(corner..corner + 1),
        }
        Some(index as u32)
    }

    /// Makes indices count from the first value of the file, if so many before the part are enough.
    fn shift(&self, values: &mut [u32], before: usize) -> Option<()> {
        for corners in &self.relative {
            for value in &mut values[corners.clone()] {
                *value = value.wrapping_add(before as u32);
            }
        }
        (self.reach <= before).then_some(())
    }
}

impl Indices {
    /// The index from 0 that a number at an offset of the file, of a corner, stands for, if there is
    /// such.
    fn resolve(&mut self, (at, corner): (usize, usize), number: i64, count: usize) -> Option<u32> {
        if let Some(part) = &mut self.part {
            return part.resolve(number, count, corner);
        }
        let index = match number {
            0 => return None,
            1.. => number - 1,
            _ => number.checked_add(i64::try_from(count).ok()?)?,
        };
        let index = u32::try_from(index).ok().filter(|index| *index < NONE)?;
        if index as usize >= count {
            if number < 0 {
                return None;
            }
            if self.ahead.last().is_none_or(|(last, _)| index > *last) {
                self.ahead.push((index, at));
            }
        }
        Some(index)
    }

    /// Fails for the first index that is out of range now that all values are read.
    fn check(&self, text: &Scanner<'_>, count: usize, what: &str) -> Result<(), ParseError> {
        match self.ahead.iter().find(|(index, _)| *index as usize >= count) {
            Some(&(index, at)) => {
                let number = u64::from(index) + 1;
                Err(text.error_at(at, format!("{what} {number}, but the file has {count}")))
            }
            None => Ok(()),
        }
    }
}

/// Says that a number stands for no value.
fn missing(text: &Scanner<'_>, at: usize, number: i64, count: usize, what: &str) -> ParseError {
    match number {
        0 => text.error_at(at, format!("{what} index 0; the first is 1")),
        _ => text.error_at(at, format!("{what} {number}, but there are {count} so far")),
    }
}

struct Reader<'a> {
    text: Scanner<'a>,
    data: MeshData,
    /// Colours of the first vertices, as many as were needed so far.
    colours: Vec<[f64; 4]>,
    uvs: Vec<[f64; 2]>,
    normals: Vec<Vec3>,
    vertex_indices: Indices,
    uv_indices: Indices,
    normal_indices: Indices,
    /// For each corner its index into `uvs`, `NONE` without; empty as long as no corner has one.
    corner_uv: Vec<u32>,
    corner_normal: Vec<u32>,
    /// The first corners that name a value which is not there.
    missing_uv: Option<ParseError>,
    missing_normal: Option<ParseError>,
    /// The vertices of all faces, and where each face begins.
    corners: Vec<u32>,
    start: Vec<u32>,
    /// Statements that name what follows, in order.
    named: Vec<Named>,
    weights: usize,
    extra_numbers: usize,
    points_and_lines: usize,
    smoothing: usize,
    free_form: usize,
    has_object: bool,
    has_group: bool,
    understood: usize,
    unknown: usize,
    first_unknown: Option<(usize, &'a [u8])>,
}

/// How many values were read.
#[derive(Clone, Copy, Default)]
struct Counts {
    vertices: usize,
    uvs: usize,
    normals: usize,
    faces: usize,
    corners: usize,
}

impl Counts {
    fn add(&mut self, other: Self) {
        self.vertices += other.vertices;
        self.uvs += other.uvs;
        self.normals += other.normals;
        self.faces += other.faces;
        self.corners += other.corners;
    }
}

/// A slice of each part.
fn each<'p, 'a, T>(parts: &'p [Reader<'a>], f: impl Fn(&'p Reader<'a>) -> &'p [T]) -> Vec<&'p [T]> {
    parts.iter().map(f).collect()
}

/// A statement whose name is wanted only when all faces are read.
struct Named {
    keyword: Keyword,
    /// Faces before it.
    face: usize,
    /// Where it begins, and where its name does.
    at: usize,
    name_at: usize,
}

#[derive(Clone, Copy)]
enum Keyword {
    Group,
    Object,
    Material,
    Library,
    Tag,
}

/// What the named statements say.
#[derive(Default)]
struct Names {
    groups: LabelBuilder,
    materials: LabelBuilder,
    library: Option<String>,
    creases: CreaseList,
    /// Names of tags that mean nothing here, each once.
    other_tags: Vec<String>,
    /// The first tag that could not be read.
    bad_tag: Option<ParseError>,
}

impl Names {
    /// Takes the statements in order. `name` reads the name at an offset.
    fn new(statements: &[Named], text: &Scanner<'_>, face_count: usize) -> Self {
        let mut names = Self::default();
        for statement in statements {
            let name = Scanner { at: statement.name_at, ..*text }.statement_name();
            match statement.keyword {
                Keyword::Group | Keyword::Object => {
                    names.groups.fill(statement.face);
                    let plain = matches!(statement.keyword, Keyword::Group) && name.is_empty();
                    names.groups.set(if plain { "default".into() } else { name });
                }
                Keyword::Material => {
                    names.materials.fill(statement.face);
                    names.materials.set(name);
                }
                Keyword::Library => {
                    let library = names.library.get_or_insert_default();
                    if !library.is_empty() {
                        library.push('\n');
                    }
                    library.push_str(&name);
                }
                Keyword::Tag => names.tag(&name, || text.line_of(statement.at)),
            }
        }
        if !statements.is_empty() {
            names.groups.fill(face_count);
            names.materials.fill(face_count);
        }
        names
    }

    /// A tag for a subdivision surface. The mesh is whole without one that is not understood.
    fn tag(&mut self, text: &str, line: impl Fn() -> u64) {
        match self.creases.add_tag(text, Place::File) {
            Ok(Some(other)) if self.other_tags.iter().any(|name| name == other) => {}
            Ok(Some(other)) => self.other_tags.push(other.into()),
            Err(error) if self.bad_tag.is_none() => {
                self.bad_tag = Some(ParseError { place: Place::Line(line()), ..error });
            }
            Ok(None) | Err(_) => {}
        }
    }
}

impl<'a> Reader<'a> {
    /// A reader of a file, or of a part of one.
    fn new(text: Scanner<'a>, is_part: bool) -> Self {
        let indices = || Indices { part: is_part.then(PartIndices::default), ..Indices::default() };
        Self {
            text,
            data: MeshData::default(),
            colours: Vec::new(),
            uvs: Vec::new(),
            normals: Vec::new(),
            vertex_indices: indices(),
            uv_indices: indices(),
            normal_indices: indices(),
            corner_uv: Vec::new(),
            corner_normal: Vec::new(),
            missing_uv: None,
            missing_normal: None,
            corners: Vec::new(),
            start: vec![0],
            named: Vec::new(),
            weights: 0,
            extra_numbers: 0,
            points_and_lines: 0,
            smoothing: 0,
            free_form: 0,
            has_object: false,
            has_group: false,
            understood: 0,
            unknown: 0,
            first_unknown: None,
        }
    }

    /// Reads all statements.
    fn statements(mut self) -> Result<Self, ParseError> {
        while !self.text.is_at_end() {
            self.statement()?;
        }
        Ok(self)
    }

    fn counts(&self) -> Counts {
        Counts {
            vertices: self.data.positions.len(),
            uvs: self.uvs.len(),
            normals: self.normals.len(),
            faces: self.start.len() - 1,
            corners: self.corners.len(),
        }
    }

    /// The reader of all parts of a file, if it is as if it had read them one after the other.
    fn joined(mut parts: Vec<Self>) -> Option<Self> {
        let mut all = Counts::default();
        let mut before = Vec::with_capacity(parts.len());
        for part in &parts {
            before.push(all);
            all.add(part.counts());
        }
        if all.corners > u32::MAX as usize {
            return None;
        }
        let with_uvs = parts.iter().any(|part| !part.corner_uv.is_empty());
        let with_normals = parts.iter().any(|part| !part.corner_normal.is_empty());
        par::map(parts.iter_mut().zip(before), |(part, before)| {
            for (corners, wanted) in
                [(&mut part.corner_uv, with_uvs), (&mut part.corner_normal, with_normals)]
            {
                corners.resize(if wanted { part.corners.len() } else { 0 }, NONE);
            }
            part.shift(before, all)
        })
        .into_iter()
        .collect::<Option<()>>()?;

        let mut whole = Self::new(parts[0].text, false);
        whole.data.positions = par::concat(&each(&parts, |part| &part.data.positions));
        whole.uvs = par::concat(&each(&parts, |part| &part.uvs));
        whole.normals = par::concat(&each(&parts, |part| &part.normals));
        whole.corners = par::concat(&each(&parts, |part| &part.corners));
        whole.corner_uv = par::concat(&each(&parts, |part| &part.corner_uv));
        whole.corner_normal = par::concat(&each(&parts, |part| &part.corner_normal));
        // The end of one part is the beginning of the next.
        let mut starts = each(&parts, |part| &part.start[1..]);
        starts.insert(0, &[0]);
        whole.start = par::concat(&starts);
        let mut vertices = 0;
        for part in parts {
            if !part.colours.is_empty() {
                whole.colours.resize(vertices, WHITE);
                whole.colours.extend(part.colours);
            }
            vertices += part.data.positions.len();
            whole.named.extend(part.named);
            whole.weights += part.weights;
            whole.extra_numbers += part.extra_numbers;
            whole.points_and_lines += part.points_and_lines;
            whole.smoothing += part.smoothing;
            whole.free_form += part.free_form;
            whole.has_object |= part.has_object;
            whole.has_group |= part.has_group;
            whole.understood += part.understood;
            whole.unknown += part.unknown;
            whole.first_unknown = whole.first_unknown.or(part.first_unknown);
        }
        Some(whole)
    }

    /// Makes all that counts from the beginning of a part count from the beginning of the file, if
    /// every index is one of a value.
    fn shift(&mut self, before: Counts, all: Counts) -> Option<()> {
        for (indices, values, before, all) in [
            (&self.vertex_indices, &mut self.corners, before.vertices, all.vertices),
            (&self.uv_indices, &mut self.corner_uv, before.uvs, all.uvs),
            (&self.normal_indices, &mut self.corner_normal, before.normals, all.normals),
        ] {
            let part = indices.part.as_ref()?;
            part.shift(values, before)?;
            (part.end <= all).then_some(())?;
        }
        self.start.iter_mut().for_each(|start| *start += before.corners as u32);
        self.named.iter_mut().for_each(|named| named.face += before.faces);
        (self.missing_uv.is_none() && self.missing_normal.is_none()).then_some(())
    }

    /// Reads one statement, or a comment or an empty line, up to the next line.
    fn statement(&mut self) -> Result<(), ParseError> {
        self.text.skip_blanks_and_continuations();
        if self.text.is_at_line_end() {
            self.text.skip_line();
            return Ok(());
        }
        let at = self.text.at;
        let keyword = self.text.word();
        self.understood += 1;
        match keyword {
            b"v" => return self.vertex(),
            b"f" | b"fo" => return self.polygon(),
            b"vt" => return self.uv(),
            b"vn" => return self.normal(),
            b"g" => {
                self.has_group = true;
                self.named(Keyword::Group, at);
            }
            b"o" => {
                self.has_object = true;
                self.named(Keyword::Object, at);
            }
            b"usemtl" => self.named(Keyword::Material, at),
            b"mtllib" => self.named(Keyword::Library, at),
            b"t" => self.named(Keyword::Tag, at),
            b"s" => {
                let on = !matches!(self.text.statement_name().as_str(), "off" | "0" | "");
                self.smoothing += usize::from(on);
            }
            b"p" | b"l" => {
                self.points_and_lines += 1;
                self.text.skip_statement();
            }
            _ if FREE_FORM.contains(&keyword) => {
                self.free_form += 1;
                self.text.skip_statement();
            }
            _ if keyword.contains(&0) => {
                let message = format!("found {}; a NUL byte is no text", quoted(keyword));
                return Err(self.text.error_at(at, message).expected("an OBJ statement"));
            }
            _ => {
                self.understood -= 1;
                self.unknown += 1;
                self.first_unknown.get_or_insert((at, keyword));
                self.text.skip_statement();
            }
        }
        Ok(())
    }

    /// Keeps where a statement is whose name is read later.
    fn named(&mut self, keyword: Keyword, at: usize) {
        let (face, name_at) = (self.start.len() - 1, self.text.at);
        self.named.push(Named { keyword, face, at, name_at });
        self.text.skip_statement();
    }

    /// Numbers up to the end of the statement: their count, and the first ones.
    fn numbers<const N: usize>(&mut self) -> Result<(usize, [f64; N]), ParseError> {
        let mut values = [0.0; N];
        let mut count = 0;
        loop {
            self.text.skip_blanks_and_continuations();
            if self.text.is_at_line_end() {
                self.text.skip_line();
                return Ok((count, values));
            }
            let value = self.text.number()?;
            if count < N {
                values[count] = value;
            }
            count += 1;
        }
    }

    fn vertex(&mut self) -> Result<(), ParseError> {
        let at = self.text.at;
        let (count, n) = self.numbers::<7>()?;
        if count < 3 {
            let message = format!("{} after v", counted(count, "number"));
            return Err(self.text.error_at(at, message).expected("3 numbers, x y z"));
        }
        let before = self.data.positions.len();
        self.data.positions.push(Vec3::new(n[0], n[1], n[2]));
        match count {
            3 => return Ok(()),
            4 => {
                self.weights += usize::from(n[3].to_bits() != 1.0_f64.to_bits());
                return Ok(());
            }
            6 | 7 => {}
            _ => {
                self.extra_numbers += 1;
                return Ok(());
            }
        }
        self.colours.resize(before, WHITE);
        self.colours.push([n[3], n[4], n[5], if count == 7 { n[6] } else { 1.0 }]);
        Ok(())
    }

    fn uv(&mut self) -> Result<(), ParseError> {
        let at = self.text.at;
        let (count, [u, v]) = self.numbers::<2>()?;
        if count == 0 {
            return Err(self.text.error_at(at, "no number after vt").expected("u v"));
        }
        self.uvs.push([u, v]);
        Ok(())
    }

    fn normal(&mut self) -> Result<(), ParseError> {
        let at = self.text.at;
        let (count, n) = self.numbers::<3>()?;
        if count < 3 {
            let message = format!("{} after vn", counted(count, "number"));
            return Err(self.text.error_at(at, message).expected("3 numbers, x y z"));
        }
        self.normals.push(n.into());
        Ok(())
    }

    fn polygon(&mut self) -> Result<(), ParseError> {
        let start = self.text.at;
        loop {
            self.text.skip_blanks_and_continuations();
            if self.text.is_at_line_end() {
                self.text.skip_line();
                break;
            }
            self.corner()?;
        }
        let end = self.corners.len();
        for corners in [&mut self.corner_uv, &mut self.corner_normal] {
            if !corners.is_empty() {
                corners.resize(end, NONE);
            }
        }
        let Ok(end) = u32::try_from(end) else {
            return Err(too_many_corners(Place::Line(self.text.line_of(start))));
        };
        self.start.push(end);
        Ok(())
    }

    /// Reads one corner: `v`, `v/vt`, `v//vn` or `v/vt/vn`, with nothing behind a slash allowed.
    fn corner(&mut self) -> Result<(), ParseError> {
        const FORM: &str = "a corner v, v/vt, v//vn or v/vt/vn of whole numbers";
        let at = self.text.at;
        let corner = self.corners.len();
        let wrong = |text: &Scanner<'_>| Scanner { at, ..*text }.unexpected(FORM);
        let index = |text: &mut Scanner<'_>| text.digits(FORM).map_err(|_| wrong(text));
        let ends = |text: &Scanner<'_>| {
            text.peek().is_none_or(|b| b.is_ascii_whitespace() || matches!(b, 0x0b | b'#' | b'\\'))
        };

        let number = index(&mut self.text)?;
        let count = self.data.positions.len();
        let Some(vertex) = self.vertex_indices.resolve((at, corner), number, count) else {
            return Err(missing(&self.text, at, number, count, "vertex"));
        };
        self.corners.push(vertex);
        if ends(&self.text) {
            return Ok(());
        }
        if self.text.peek() != Some(b'/') {
            return Err(wrong(&self.text));
        }
        self.text.at += 1;
        if self.text.peek() != Some(b'/') && !ends(&self.text) {
            let number = index(&mut self.text)?;
            let count = self.uvs.len();
            let uv = self.uv_indices.resolve((at, corner), number, count).unwrap_or_else(|| {
                let error = || missing(&self.text, at, number, count, "vt");
                self.missing_uv.get_or_insert_with(error);
                NONE
            });
            self.corner_uv.resize(corner, NONE);
            self.corner_uv.push(uv);
        }
        if self.text.peek() == Some(b'/') {
            self.text.at += 1;
            if !ends(&self.text) {
                let number = index(&mut self.text)?;
                let count = self.normals.len();
                let normal =
                    self.normal_indices.resolve((at, corner), number, count).unwrap_or_else(|| {
                        let error = || missing(&self.text, at, number, count, "vn");
                        self.missing_normal.get_or_insert_with(error);
                        NONE
                    });
                self.corner_normal.resize(corner, NONE);
                self.corner_normal.push(normal);
            }
        }
        if ends(&self.text) { Ok(()) } else { Err(wrong(&self.text)) }
    }

    fn finish(mut self) -> Result<MeshData, ParseError> {
        if let (0, Some((at, word))) = (self.understood, self.first_unknown) {
            let message = format!("found {}, and no OBJ statement in the file", quoted(word));
            return Err(self.text.error_at(at, message).expected("v, vt, vn or f"));
        }
        self.vertex_indices.check(&self.text, self.data.positions.len(), "vertex")?;
        // The mesh is whole without a texture coordinate or normal that is not there.
        if let Err(e) = self.uv_indices.check(&self.text, self.uvs.len(), "vt") {
            let uvs = self.uvs.len() as u32;
            self.corner_uv.iter_mut().filter(|i| **i >= uvs).for_each(|i| *i = NONE);
            self.missing_uv.get_or_insert(e);
        }
        if let Err(e) = self.normal_indices.check(&self.text, self.normals.len(), "vn") {
            let normals = self.normals.len() as u32;
            self.corner_normal.iter_mut().filter(|i| **i >= normals).for_each(|i| *i = NONE);
            self.missing_normal.get_or_insert(e);
        }
        let names = Names::new(&self.named, &self.text, self.start.len() - 1);
        self.data.faces = Faces::from_starts(take(&mut self.start), take(&mut self.corners));
        let missing = [self.missing_uv.take(), self.missing_normal.take(), names.bad_tag];
        self.data.notes.extend(missing.into_iter().flatten().map(|e| format!("passed over {e}")));
        self.note_what_was_left_out(&names.other_tags);
        self.finish_colours();
        self.finish_uvs();
        self.finish_normals();
        if !names.creases.is_empty() || names.creases.boundary.is_some() {
            self.data.creases = Some(names.creases);
        }
        self.data.groups = names.groups.finish();
        self.data.materials = names.materials.finish();
        self.data.material_library = names.library;
        Ok(self.data)
    }

    fn note_what_was_left_out(&mut self, other_tags: &[String]) {
        let notes = &mut self.data.notes;
        if let Some((at, word)) = self.first_unknown {
            let (n, line) = (counted(self.unknown, "unknown statement"), self.text.line_of(at));
            notes.push(format!("{n} skipped, the first at line {line}: {}", quoted(word)));
        }
        if !other_tags.is_empty() {
            notes.push(format!("tags left out: {}", other_tags.join(", ")));
        }
        if self.free_form > 0 {
            notes.push(format!("{} skipped", counted(self.free_form, "free-form statement")));
        }
        if self.points_and_lines > 0 {
            let n = counted(self.points_and_lines, "point or line statement");
            notes.push(format!("{n} skipped: only faces are read"));
        }
        if self.smoothing > 0 {
            notes.push("smoothing groups left out".into());
        }
        if self.weights > 0 {
            notes.push("vertex weights (v x y z w) left out".into());
        }
        if self.extra_numbers > 0 {
            let n = counted(self.extra_numbers, "v statement");
            notes.push(format!("{n} with 5 or more than 7 numbers: only x y z read"));
        }
        if self.has_object && self.has_group {
            notes.push("both o and g name groups: the last before a face counts".into());
        }
    }

    fn finish_colours(&mut self) {
        let vertices = self.data.positions.len();
        if self.colours.is_empty() {
            return;
        }
        // `resize` filled the gaps, but a vertex behind the last colour is one as well.
        if self.colours.len() < vertices {
            self.data.notes.push("vertices without a colour are white".into());
        }
        self.colours.resize(vertices, WHITE);
        scale_large_colours(&mut self.colours, &mut self.data.notes);
        self.data.colours = Some(take(&mut self.colours));
    }

    fn finish_uvs(&mut self) {
        let (vertices, corners) = (self.data.positions.len(), self.data.faces.corners());
        if self.uvs.is_empty() {
            return;
        }
        if self.uvs.len() == vertices && is_identity(&self.corner_uv, corners) {
            self.data.uvs = Some(take(&mut self.uvs));
            return;
        }
        if self.corner_uv.is_empty() {
            self.data.notes.push("no face uses the texture coordinates: left out".into());
            return;
        }
        let of = |i: u32| if i == NONE { [0.0; 2] } else { self.uvs[i as usize] };
        if self.corner_uv.contains(&NONE) {
            self.data.notes.push("corners without texture coordinates have 0 0".into());
        }
        let bits = |uv: [f64; 2]| uv.map(f64::to_bits);
        let per_vertex =
            one_per_vertex(vertices, corners, |corner| bits(of(self.corner_uv[corner])));
        match per_vertex {
            Some(uvs) => {
                self.data.uvs =
                    Some(uvs.iter().map(|uv| uv.unwrap_or_default().map(f64::from_bits)).collect());
            }
            None => self.data.corner_uvs = Some(self.corner_uv.iter().map(|i| of(*i)).collect()),
        }
    }

    fn finish_normals(&mut self) {
        let (vertices, corners) = (self.data.positions.len(), self.data.faces.corners());
        if self.normals.is_empty() {
            return;
        }
        if self.normals.len() == vertices && is_identity(&self.corner_normal, corners) {
            self.data.normals = Some(take(&mut self.normals));
            return;
        }
        let notes = &mut self.data.notes;
        if self.corner_normal.is_empty() {
            notes.push("no face uses the normals: left out".into());
            return;
        }
        if self.corner_normal.contains(&NONE) {
            notes.push("normals left out: some corners have none".into());
            return;
        }
        let bits = |n: Vec3| [n.x, n.y, n.z].map(f64::to_bits);
        let per_vertex = one_per_vertex(vertices, corners, |corner| {
            bits(self.normals[self.corner_normal[corner] as usize])
        });
        if let Some(normals) = per_vertex {
            let normal = |n: &Option<[u64; 3]>| n.unwrap_or_default().map(f64::from_bits).into();
            self.data.normals = Some(normals.iter().map(normal).collect());
        } else {
            let of = |i: &u32| self.normals[*i as usize];
            self.data.corner_normals = Some(self.corner_normal.iter().map(of).collect());
        }
    }
}

/// Colour of a vertex that the file gives none.
const WHITE: [f64; 4] = [1.0; 4];

/// Whether every corner that has a vertex `i` has value `i` too. True without faces.
fn is_identity(values: &[u32], corners: &[u32]) -> bool {
    values == corners
}

/// The value of each vertex, if all its corners have the same.
fn one_per_vertex<V: PartialEq + Copy>(
    vertices: usize,
    corners: &[u32],
    value: impl Fn(usize) -> V,
) -> Option<Vec<Option<V>>> {
    let mut values = vec![None; vertices];
    for (corner, &vertex) in corners.iter().enumerate() {
        let value = value(corner);
        if *values[vertex as usize].get_or_insert(value) != value {
            return None;
        }
    }
    Some(values)
}

/// Writes an OBJ file.
pub(crate) fn encode(
    data: &MeshData,
    options: &WriteOptions,
    out: &mut dyn Write,
) -> Result<Vec<String>, Error> {
    let single = options.single_precision;
    write_header(data.material_library.as_deref(), out)?;
    let opaque = data.colours.iter().flatten().all(is_opaque);
    par::write_rows(out, data.positions.len(), ROWS, |rows, out| {
        vertex_rows(data, single, opaque, rows, out);
    })?;
    let uv_of_corner = write_uvs(data, single, out)?;
    let normal_of_corner = write_normals(data, single, out)?;
    let uvs = IndexOf::new(uv_of_corner.as_deref(), data.uvs.is_some());
    let normals = IndexOf::new(normal_of_corner.as_deref(), data.normals.is_some());
    par::write_rows(out, data.faces.len(), ROWS, |rows, out| {
        let before = rows.start.checked_sub(1);
        let label = |labels: &Option<Labels>| Some(labels.as_ref()?.of_face[before?]);
        let names = [&data.groups, &data.materials]
            .map(|labels| labels.as_ref().map_or(&[][..], |labels| &labels.names[..]));
        let before = [label(&data.groups), label(&data.materials)];
        face_rows(data, names, before, [uvs, normals], rows, out);
    })?;
    if let Some(creases) = &data.creases {
        creases.write_tags(single, out)?;
    }
    Ok(notes(data.uvs.is_some() && data.corner_uvs.is_some(), opaque))
}

/// As [`encode`], of a mesh that is made meanwhile.
pub(crate) fn encode_blocks(
    blocks: &Checked<'_>,
    options: &WriteOptions,
    out: &mut dyn Write,
) -> Result<Vec<String>, Error> {
    let (shape, single) = (&blocks.shape, options.single_precision);
    write_header(shape.material_library, out)?;
    let opaque = blocks.all_colours(is_opaque);
    let wanted = Attributes { positions: true, colours: shape.colours, ..Attributes::NONE };
    blocks.write_vertices(out, wanted, |data, out| {
        vertex_rows(data, single, opaque, 0..data.positions.len(), out);
    })?;
    if shape.uvs {
        let wanted = Attributes { uvs: true, ..Attributes::NONE };
        blocks.write_vertices(out, wanted, |data, out| {
            statement_rows("vt", data.uvs.as_deref().unwrap_or_default(), single, out);
        })?;
    }
    if shape.normals {
        let wanted = Attributes { normals: true, ..Attributes::NONE };
        blocks.write_vertices(out, wanted, |data, out| {
            let normals = data.normals.as_deref().unwrap_or_default();
            statement_rows::<3>("vn", bytemuck::cast_slice(normals), single, out);
        })?;
    }
    let names = [shape.groups, shape.materials].map(Option::unwrap_or_default);
    let [uvs, normals] = [shape.uvs, shape.normals].map(|has| IndexOf::new(None, has));
    blocks.write_faces(out, |data, before, out| {
        face_rows(data, names, before, [uvs, normals], 0..data.faces.len(), out);
    })?;
    Ok(notes(false, opaque))
}

fn write_header(material_library: Option<&str>, out: &mut dyn Write) -> Result<(), Error> {
    out.write_all(b"# fairform\n")?;
    for library in material_library.iter().flat_map(|l| l.lines()) {
        writeln!(out, "mtllib {}", statement_name(library))?;
    }
    Ok(())
}

fn is_opaque(colour: &[f64; 4]) -> bool {
    colour[3].to_bits() == 1.0_f64.to_bits()
}

fn notes(both_uvs: bool, opaque: bool) -> Vec<String> {
    let mut notes = left_out(&[(both_uvs, "uvs per vertex beside those per corner")], "OBJ");
    if !opaque {
        notes.push("alpha written as a seventh number of v, which few programs read".into());
    }
    notes
}

/// Appends the `v` statements of some vertices.
fn vertex_rows(data: &MeshData, single: bool, opaque: bool, rows: Range<usize>, out: &mut Vec<u8>) {
    let mut numbers = NumberWriter::new(single);
    for i in rows {
        out.push(b'v');
        numbers.write_all(out, &<[f64; 3]>::from(data.positions[i]));
        if let Some(colours) = &data.colours {
            numbers.write_all(out, &colours[i][..if opaque { 3 } else { 4 }]);
        }
        out.push(b'\n');
    }
}

/// Writes statements of a keyword and numbers.
fn write_statements<const N: usize>(
    keyword: &str,
    values: &[[f64; N]],
    single: bool,
    out: &mut dyn Write,
) -> Result<(), Error> {
    par::write_rows(out, values.len(), ROWS, |rows, out| {
        statement_rows(keyword, &values[rows], single, out);
    })?;
    Ok(())
}

/// Appends statements of a keyword and numbers.
fn statement_rows<const N: usize>(
    keyword: &str,
    values: &[[f64; N]],
    single: bool,
    out: &mut Vec<u8>,
) {
    let mut numbers = NumberWriter::new(single);
    for value in values {
        out.extend_from_slice(keyword.as_bytes());
        numbers.write_all(out, value);
        out.push(b'\n');
    }
}

/// Equal values once, in order, and for each value its index there from 0.
fn distinct<const N: usize>(values: &[[f64; N]]) -> (Vec<[f64; N]>, Vec<u32>) {
    let mut known: HashMap<[u64; N], u32> = HashMap::new();
    let mut distinct = Vec::new();
    let index = values.iter().map(|value| {
        *known.entry(value.map(f64::to_bits)).or_insert_with(|| {
            distinct.push(*value);
            distinct.len() as u32 - 1
        })
    });
    let index = index.collect();
    (distinct, index)
}

/// Writes the `vt` statements, equal ones of corners once. For each corner its index from 0,
/// unless that is its vertex.
fn write_uvs(
    data: &MeshData,
    single: bool,
    out: &mut dyn Write,
) -> Result<Option<Vec<u32>>, Error> {
    let Some(corner_uvs) = &data.corner_uvs else {
        write_statements("vt", data.uvs.as_deref().unwrap_or_default(), single, out)?;
        return Ok(None);
    };
    let (uvs, of_corner) = distinct(corner_uvs);
    write_statements("vt", &uvs, single, out)?;
    Ok(Some(of_corner))
}

/// Writes the `vn` statements, equal ones of corners once. For each corner its index from 0, unless that
/// is its vertex.
fn write_normals(
    data: &MeshData,
    single: bool,
    out: &mut dyn Write,
) -> Result<Option<Vec<u32>>, Error> {
    let Some(corner_normals) = &data.corner_normals else {
        let normals = data.normals.as_deref().unwrap_or_default();
        write_statements::<3>("vn", bytemuck::cast_slice(normals), single, out)?;
        return Ok(None);
    };
    let (normals, of_corner) = distinct::<3>(bytemuck::cast_slice(corner_normals));
    write_statements("vn", &normals, single, out)?;
    Ok(Some(of_corner))
}

/// What stands behind a slash of a corner.
#[derive(Clone, Copy)]
enum IndexOf<'a> {
    Nothing,
    Vertex,
    /// For each corner its index from 0.
    Corner(&'a [u32]),
}

impl<'a> IndexOf<'a> {
    fn new(of_corner: Option<&'a [u32]>, per_vertex: bool) -> Self {
        match of_corner {
            Some(of_corner) => Self::Corner(of_corner),
            None if per_vertex => Self::Vertex,
            None => Self::Nothing,
        }
    }

    fn get(self, corner: usize, vertex: u32) -> Option<u64> {
        match self {
            Self::Nothing => None,
            Self::Vertex => Some(u64::from(vertex) + 1),
            Self::Corner(index) => Some(u64::from(index[corner]) + 1),
        }
    }
}

/// Appends the `f` statements of some faces, and the names that begin there; `names` of groups and of
/// materials, and the labels of the face `before`.
fn face_rows(
    data: &MeshData,
    names: [&[String]; 2],
    mut before: [Option<u32>; 2],
    [uvs, normals]: [IndexOf<'_>; 2],
    rows: Range<usize>,
    out: &mut Vec<u8>,
) {
    let corners = data.faces.corners();
    let mut numbers = NumberWriter::new(false);
    for face in rows {
        let labels = [("g ", &data.groups), ("usemtl ", &data.materials)];
        for (((keyword, labels), names), before) in labels.into_iter().zip(names).zip(&mut before) {
            let Some(labels) = labels else { continue };
            let label = labels.of_face[face];
            let name = &names[label as usize];
            let goes_on = match before.replace(label) {
                Some(last) => last == label,
                // A face before the first name needs no statement.
                None => name.is_empty(),
            };
            if !goes_on {
                out.extend_from_slice(keyword.as_bytes());
                out.extend_from_slice(statement_name(name).as_bytes());
                out.push(b'\n');
            }
        }
        out.push(b'f');
        let own = data.faces.range(FaceId(face as u32));
        for (corner, &vertex) in own.clone().zip(&corners[own]) {
            let (uv, normal) = (uvs.get(corner, vertex), normals.get(corner, vertex));
            out.push(b' ');
            numbers.whole(out, u64::from(vertex) + 1);
            if uv.is_some() || normal.is_some() {
                out.push(b'/');
            }
            if let Some(uv) = uv {
                numbers.whole(out, uv);
            }
            if let Some(normal) = normal {
                out.push(b'/');
                numbers.whole(out, normal);
            }
        }
        out.push(b'\n');
    }
}

/// A name as a statement can hold it: on one line, no comment, no continuation.
pub(crate) fn statement_name(name: &str) -> String {
    let line = name.replace(|c: char| c.is_control(), " ");
    let mut safe = line.trim().replace(" #", " _");
    if safe.starts_with('#') {
        safe.replace_range(..1, "_");
    }
    if safe.ends_with('\\') {
        safe.pop();
        safe.push('_');
    }
    safe
}

#[cfg(test)]
mod tests {
    use proptest::collection::vec;
    use proptest::prelude::*;
    use proptest::sample::select;

    use super::*;

    /// One line each, with and without fault; some continue on the next.
    const LINES: &[&str] = &[
        "v 0 1 2",
        "v 0.5 -1 2 1",
        "v 1 2 3 0.5",
        "v 1 2 3 0.1 0.2 0.3",
        "v 1 2 3 100 200 255",
        "  v\t1 \\\n 2 \\\r\n3 # end",
        "v 1 2 3 4 5",
        "vt 0.5 0.25",
        "vt 1 0",
        "vn 0 0 1",
        "vn 1 0 0",
        "f 1 2 3",
        "f 3 2 1 4",
        "f -1 -2 -3",
        "f -3 -1 \\\n-2",
        "f 1/1 2/2 3/1",
        "f -1/-1/-1 -2/-1/-2 -3/-2/-1",
        "f 1//1 2//-1 -1//2",
        "f -4 2/-1 1//1",
        "f",
        "f 9 8 7",
        "f 1/7 2/-9 3//40",
        "g a",
        "g b \\\nc # d \\",
        "g",
        "o thing",
        "usemtl red",
        "usemtl",
        "mtllib a.mtl",
        "s 1",
        "s off",
        "t crease 2/1/0 0 1 2.5",
        "t hole 1/0/0 0",
        "t crease",
        "t other 0/0/0",
        "p 1",
        "l 1 2",
        "curv 0 1",
        "what 1 2",
        "# comment \\",
        "",
        "\\",
        "\\\r",
        "\r",
        "v 1 2",
        "f 1 x 3",
        "f 0 1 2",
        "f -50 1 2",
    ];

    fn same(text: &[u8]) {
        let whole = parse(text, 1);
        for parts in [2, 3, 7, text.len()] {
            // NaN does not occur, so equal is the same.
            assert_eq!(parse(text, parts), whole, "{parts} parts");
        }
    }

    /// Whether the text is read in parts, and not again.
    fn is_joined(text: &str, parts: usize) -> bool {
        let parts = Scanner::new(text.as_bytes()).unwrap().parts(parts, ends_statement);
        let parts: Vec<_> = parts
            .into_iter()
            .map(|part| Reader::new(part, true).statements())
            .collect::<Result<_, _>>()
            .unwrap();
        parts.len() > 1 && Reader::joined(parts).is_some()
    }

    #[test]
    fn every_statement_is_read_in_parts() {
        let text = "v 0 0 0 1 1 1\nvt 0 0\nvn 0 0 1\nv 1 0 0\nv 0 1 0\ng a\nf 1 2 3\nf -3/-1 -2 -1//-1\n\
            usemtl m\nv 1 1 1\nf 4/1/1 -1/1/1 -2/1/1\nt hole 1/0/0 1\n";
        assert!(is_joined(text, 5) && is_joined(text, 12));
        same(text.as_bytes());
        let data = parse(text.as_bytes(), 12).unwrap();
        assert_eq!(data.faces.corners(), [0, 1, 2, 0, 1, 2, 3, 3, 2]);
        assert_eq!(data.groups.unwrap().of_face, [0, 0, 0]);
    }

    #[test]
    fn the_first_error_of_the_file_is_named() {
        let good = "v 0 0 0\n".repeat(40);
        for (bad, message) in [
            ("f 1 2 x\nf 1 y\n", "line 41: found 'x'"),
            ("f 1 2 -99\nf 1 y\n", "line 41: vertex -99, but there are 40 so far"),
            ("f 1 2 99\nf 1 2 100\n", "line 41: vertex 99, but the file has 80"),
        ] {
            let text = format!("{good}{bad}{good}");
            for parts in [1, 2, 5, 30] {
                let error = parse(text.as_bytes(), parts).unwrap_err().to_string();
                assert!(error.starts_with(message), "{error}");
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig {
            failure_persistence: None, ..ProptestConfig::with_cases(400)
        })]

        #[test]
        fn parts_give_what_the_whole_gives(
            lines in vec(prop_oneof![9 => 0..LINES.len() - 8, 1 => 0..LINES.len()], 0..60),
            ends in vec(select(&["\n", "\r\n", "\r"][..]), 60),
        ) {
            let lines = lines.iter().zip(&ends).flat_map(|(line, end)| [LINES[*line], end]);
            let text: String = "v 1 0 0\nv 0 1 0\nv 0 0 1\nv 1 1 1\n".chars().chain(lines.flat_map(str::chars)).collect();
            same(text.as_bytes());
        }
    }
}
