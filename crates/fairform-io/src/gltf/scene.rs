//! From nodes, meshes and primitives to one mesh.

use std::collections::{HashMap, HashSet};

use fairform::{Faces, Vec3};

use super::accessor::Buffers;
use super::json::{Attributes, Document, Node, Primitive};
use crate::data::{LabelBuilder, MeshData, too_many_corners};
use crate::error::{ParseError, Place};
use crate::par;
use crate::text::counted;
use crate::weld::distinct;

/// A linear map by its columns, and a translation.
#[derive(Clone, Copy)]
struct Affine {
    columns: [Vec3; 3],
    translation: Vec3,
}

impl Affine {
    const IDENTITY: Self = Self {
        columns: [Vec3::new(1.0, 0.0, 0.0), Vec3::new(0.0, 1.0, 0.0), Vec3::new(0.0, 0.0, 1.0)],
        translation: Vec3::ZERO,
    };

    fn of(node: &Node) -> Self {
        if let Some(m) = &node.matrix {
            let column = |i: usize| Vec3::new(m[4 * i], m[4 * i + 1], m[4 * i + 2]);
            return Self { columns: [column(0), column(1), column(2)], translation: column(3) };
        }
        let [x, y, z, w] = node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]);
        let [sx, sy, sz] = node.scale.unwrap_or([1.0; 3]);
        let columns = [
            sx * Vec3::new(
                1.0 - 2.0 * (y * y + z * z),
                2.0 * (x * y + z * w),
                2.0 * (x * z - y * w),
            ),
            sy * Vec3::new(
                2.0 * (x * y - z * w),
                1.0 - 2.0 * (x * x + z * z),
                2.0 * (y * z + x * w),
            ),
            sz * Vec3::new(
                2.0 * (x * z + y * w),
                2.0 * (y * z - x * w),
                1.0 - 2.0 * (x * x + y * y),
            ),
        ];
        Self { columns, translation: node.translation.unwrap_or_default().into() }
    }

    fn direction(&self, d: Vec3) -> Vec3 {
        let [a, b, c] = self.columns;
        d.x * a + d.y * b + d.z * c
    }

    fn point(&self, p: Vec3) -> Vec3 {
        self.direction(p) + self.translation
    }

    /// This map after the other.
    fn after(&self, first: &Self) -> Self {
        Self {
            columns: first.columns.map(|c| self.direction(c)),
            translation: self.point(first.translation),
        }
    }

    fn is_identity(&self) -> bool {
        self.columns == Self::IDENTITY.columns && self.translation == Vec3::ZERO
    }

    fn determinant(&self) -> f64 {
        let [a, b, c] = self.columns;
        a.dot(b.cross(c))
    }

    /// Where a normal goes: along the inverse transpose, which is the cofactors over the
    /// determinant.
    fn normal(&self, n: Vec3) -> Vec3 {
        let [a, b, c] = self.columns;
        let cofactors =
            Self { columns: [b.cross(c), c.cross(a), a.cross(b)], translation: Vec3::ZERO };
        (self.determinant().signum() * cofactors.direction(n)).normalized()
    }
}

/// Reads the default scene.
pub(super) fn read(document: &Document, buffers: Buffers<'_>) -> Result<MeshData, ParseError> {
    let mut reader = Reader::new(document, buffers);
    let roots = roots(document, &mut reader.notes)?;
    reader.nodes(&roots)?;
    if document.nodes.is_empty() && !document.meshes.is_empty() {
        reader.notes.push("the file has no nodes: every mesh read once where it is".into());
        for mesh in 0..document.meshes.len() {
            reader.mesh(mesh, None, &Affine::IDENTITY)?;
        }
    }
    Ok(reader.finish())
}

/// The nodes to begin with: those of the default scene, or all that are no child.
fn roots(document: &Document, notes: &mut Vec<String>) -> Result<Vec<usize>, ParseError> {
    let index = document.scene.unwrap_or(0);
    match document.scenes.get(index) {
        Some(scene) => {
            if document.scenes.len() > 1 {
                notes.push(format!("scene {index} of {} read", document.scenes.len()));
            }
            Ok(scene.nodes.clone())
        }
        None if document.scene.is_some() => {
            let n = document.scenes.len();
            Err(ParseError::file(format!("scene {index}, but the file has {n}")))
        }
        None => {
            let children: HashSet<_> = document.nodes.iter().flat_map(|n| &n.children).collect();
            Ok((0..document.nodes.len()).filter(|i| !children.contains(i)).collect())
        }
    }
}

/// Adds values behind others, without copying the first.
fn append<T>(all: &mut Vec<T>, mut values: Vec<T>) {
    if all.is_empty() {
        *all = values;
    } else {
        all.append(&mut values);
    }
}

/// Whether the vertices have an attribute: none so far, all, or some.
#[derive(Default)]
struct Optional<T> {
    values: Vec<T>,
    has: bool,
    lacks: bool,
}

impl<T: Clone> Optional<T> {
    fn append(&mut self, values: Option<Vec<T>>, count: usize, missing: &T) {
        if count == 0 {
            return;
        }
        if let Some(values) = values {
            self.has = true;
            append(&mut self.values, values);
        } else {
            self.lacks = true;
            self.values.resize(self.values.len() + count, missing.clone());
        }
    }
}

struct Reader<'a> {
    document: &'a Document,
    buffers: Buffers<'a>,
    data: MeshData,
    /// Three for each triangle.
    corners: Vec<u32>,
    normals: Optional<Vec3>,
    colours: Optional<[f64; 4]>,
    uvs: Optional<[f64; 2]>,
    groups: LabelBuilder,
    named_groups: bool,
    mesh_count: usize,
    materials: LabelBuilder,
    skipped: usize,
    left_over: usize,
    posed: bool,
    notes: Vec<String>,
}

impl<'a> Reader<'a> {
    fn new(document: &'a Document, buffers: Buffers<'a>) -> Self {
        Self {
            document,
            buffers,
            data: MeshData::default(),
            corners: Vec::new(),
            normals: Optional::default(),
            colours: Optional::default(),
            uvs: Optional::default(),
            groups: LabelBuilder::default(),
            named_groups: false,
            mesh_count: 0,
            materials: LabelBuilder::default(),
            skipped: 0,
            left_over: 0,
            posed: false,
            notes: Vec::new(),
        }
    }

    /// Walks the trees below some nodes, each node before its children.
    fn nodes(&mut self, roots: &[usize]) -> Result<(), ParseError> {
        let nodes = &self.document.nodes;
        let mut seen = vec![false; nodes.len()];
        let mut stack: Vec<_> = roots.iter().rev().map(|i| (*i, Affine::IDENTITY)).collect();
        while let Some((index, parent)) = stack.pop() {
            let Some(node) = nodes.get(index) else {
                let n = nodes.len();
                return Err(ParseError::file(format!("node {index}, but the file has {n}")));
            };
            if std::mem::replace(&mut seen[index], true) {
                let message = format!("node {index} is below itself or below two nodes");
                return Err(ParseError::file(message).expected("trees"));
            }
            let own = Affine::of(node);
            let map = if parent.is_identity() { own } else { parent.after(&own) };
            self.posed |= node.skin.is_some();
            if let Some(mesh) = node.mesh {
                self.mesh(mesh, node.name.as_deref(), &map)?;
            }
            stack.extend(node.children.iter().rev().map(|child| (*child, map)));
        }
        let unread = seen.iter().zip(nodes).filter(|(seen, n)| !**seen && n.mesh.is_some()).count();
        if unread > 0 {
            let n = counted(unread, "mesh node");
            self.notes.push(format!("{n} outside the scene unread"));
        }
        Ok(())
    }

    fn mesh(&mut self, index: usize, node: Option<&str>, map: &Affine) -> Result<(), ParseError> {
        let meshes = &self.document.meshes;
        let Some(mesh) = meshes.get(index) else {
            let n = meshes.len();
            return Err(ParseError::file(format!("mesh {index}, but the file has {n}")));
        };
        self.mesh_count += 1;
        let named = |name: &&str| !name.is_empty();
        let name = node.filter(named).or(mesh.name.as_deref().filter(named));
        self.named_groups |= name.is_some();
        self.groups.set(name.map_or_else(|| format!("mesh {index}"), str::to_string));
        // Primitives of one mesh that share all attributes share their vertices.
        let mut first_vertex = HashMap::new();
        for primitive in &mesh.primitives {
            self.posed |= primitive.targets.is_some();
            self.primitive(primitive, map, &mut first_vertex)?;
        }
        self.groups.fill(self.corners.len() / 3);
        Ok(())
    }

    fn primitive(
        &mut self,
        primitive: &Primitive,
        map: &Affine,
        first_vertex: &mut HashMap<Attributes, usize>,
    ) -> Result<(), ParseError> {
        // Many nodes may use a mesh of many primitives, even empty ones.
        self.buffers.spend(1, "a primitive")?;
        let Some(position) = primitive.attributes.position else {
            self.skipped += 1;
            return Ok(());
        };
        if !matches!(primitive.mode, 4..=6) {
            if primitive.mode > 6 {
                let message = format!("a primitive of mode {}", primitive.mode);
                return Err(ParseError::file(message).expected("0 to 6"));
            }
            self.skipped += 1;
            return Ok(());
        }
        let first = if let Some(first) = first_vertex.get(&primitive.attributes) {
            *first
        } else {
            let first = self.vertices(&primitive.attributes, position, map)?;
            first_vertex.insert(primitive.attributes, first);
            first
        };
        let count = self.buffers.count(position)?;
        let indices = if let Some(accessor) = primitive.indices {
            self.buffers.spend(self.buffers.count(accessor)?, "a primitive")?;
            self.buffers.indices(accessor)?
        } else {
            self.buffers.spend(count, "a primitive")?;
            (0..count as u32).collect()
        };
        // The largest first: it takes less than looking where the first bad one is.
        let bad = par::max(&indices)
            .is_some_and(|largest| u64::from(largest) >= count)
            .then(|| indices.iter().enumerate().find(|(_, v)| u64::from(**v) >= count))
            .flatten();
        if let Some((i, bad)) = bad {
            let accessor = primitive.indices.unwrap_or_default();
            let message = format!(
                "index {i} of accessor {accessor} is vertex {bad}, but the primitive has {count}"
            );
            return Err(ParseError::file(message));
        }
        match primitive.material {
            Some(index) => {
                let name = self.document.materials.get(index).and_then(|m| m.name.clone());
                let named = name.filter(|name| !name.is_empty());
                self.materials.set(named.unwrap_or_else(|| format!("material {index}")));
            }
            None => self.materials.set(String::new()),
        }
        self.triangles(primitive.mode, indices, first as u32, map.determinant() < 0.0)?;
        self.materials.fill(self.corners.len() / 3);
        Ok(())
    }

    /// Reads the vertices of a primitive: the number of the first.
    fn vertices(
        &mut self,
        attributes: &Attributes,
        position: usize,
        map: &Affine,
    ) -> Result<usize, ParseError> {
        let first = self.data.positions.len();
        let count = self.buffers.count(position)?;
        self.buffers.spend(count, "a primitive")?;
        if first as u64 + count > u64::from(u32::MAX) {
            return Err(ParseError::file("more than 4,294,967,295 vertices"));
        }
        let same_count = |accessor: usize, what: &str| {
            let other = self.buffers.count(accessor)?;
            if other == count {
                return Ok(());
            }
            Err(ParseError::file(format!("{other} {what} for {count} positions")))
        };
        let positions = self.buffers.elements::<3>(position, &["VEC3"], 0.0)?;
        let normals = attributes
            .normal
            .map(|accessor| {
                same_count(accessor, "normals")?;
                self.buffers.elements::<3>(accessor, &["VEC3"], 0.0)
            })
            .transpose()?;
        let colours = attributes
            .color
            .map(|accessor| {
                same_count(accessor, "colours")?;
                self.buffers.elements::<4>(accessor, &["VEC3", "VEC4"], 1.0)
            })
            .transpose()?;
        let uvs = attributes
            .texcoord
            .map(|accessor| {
                same_count(accessor, "texture coordinates")?;
                self.buffers.elements::<2>(accessor, &["VEC2"], 0.0)
            })
            .transpose()?;

        // A map that moves nothing must change no bit either.
        let still = map.is_identity();
        let mut positions: Vec<Vec3> = bytemuck::cast_vec(positions);
        if !still {
            positions.iter_mut().for_each(|p| *p = map.point(*p));
        }
        append(&mut self.data.positions, positions);
        let normals = normals.map(|normals| {
            let mut normals: Vec<Vec3> = bytemuck::cast_vec(normals);
            if !still {
                normals.iter_mut().for_each(|n| *n = map.normal(*n));
            }
            normals
        });
        let count = count as usize;
        self.normals.append(normals, count, &Vec3::ZERO);
        self.colours.append(colours, count, &[1.0; 4]);
        self.uvs.append(uvs, count, &[0.0; 2]);
        Ok(first)
    }

    fn triangles(
        &mut self,
        mode: u32,
        mut indices: Vec<u32>,
        first: u32,
        mirrored: bool,
    ) -> Result<(), ParseError> {
        if mode == 4 {
            let rest = indices.len() % 3;
            self.left_over += rest;
            indices.truncate(indices.len() - rest);
            if self.corners.is_empty() && first == 0 && !mirrored {
                self.corners = std::mem::take(&mut indices);
            }
        }
        let corners = &mut self.corners;
        let mut push = |[a, b, c]: [u32; 3]| {
            let [a, b, c] = if mirrored { [a, c, b] } else { [a, b, c] };
            corners.extend([first + a, first + b, first + c]);
        };
        match mode {
            4 => indices.as_chunks::<3>().0.iter().for_each(|t| push(*t)),
            5 => {
                for (i, w) in indices.windows(3).enumerate() {
                    // Every other triangle of a strip turns the other way. Strips repeat a vertex
                    // to jump; what comes of that is no face.
                    let [a, b, c] =
                        if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[1], w[0], w[2]] };
                    if a != b && b != c && c != a {
                        push([a, b, c]);
                    }
                }
            }
            _ => {
                if let Some((&hub, rim)) = indices.split_first() {
                    rim.windows(2).for_each(|w| push([hub, w[0], w[1]]));
                }
            }
        }
        if self.corners.len() > u32::MAX as usize {
            return Err(too_many_corners(Place::File));
        }
        Ok(())
    }

    fn finish(mut self) -> MeshData {
        let mut notes = self.notes;
        if self.skipped > 0 {
            let n = counted(self.skipped, "primitive");
            notes.push(format!("{n} of points, lines or nothing skipped: only triangles are read"));
        }
        if self.left_over > 0 {
            let n = counted(self.left_over, "corner");
            notes.push(format!("{n} behind the last whole triangle left out"));
        }
        if self.posed {
            notes.push("skins and morph targets left out: the mesh is as modelled".into());
        }
        if self.normals.has && self.normals.lacks {
            notes.push("normals left out: some vertices have none".into());
        } else if self.normals.has {
            self.data.normals = Some(self.normals.values);
        }
        if self.colours.has {
            if self.colours.lacks {
                notes.push("vertices without a colour are white".into());
            }
            self.data.colours = Some(self.colours.values);
        }
        if self.uvs.has {
            if self.uvs.lacks {
                notes.push("vertices without texture coordinates have 0 0".into());
            }
            self.data.uvs = Some(self.uvs.values);
        }
        if self.named_groups || self.mesh_count > 1 {
            self.data.groups = self.groups.finish();
        }
        self.data.materials = self.materials.finish();
        self.data.faces = Faces::uniform(3, self.corners);
        let doubled = self.data.positions.len() - distinct(&self.data.positions);
        if doubled > 0 {
            let n = counted(doubled, "vertex");
            notes.push(format!(
                "{n} at the position of another kept: glTF splits them at seams and sharp edges; \
                 welding joins them"
            ));
        }
        self.data.notes = notes;
        self.data
    }
}
