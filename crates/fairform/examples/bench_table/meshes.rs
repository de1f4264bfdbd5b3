//! The meshes that are measured: the same work in three orders of memory.

use fairform::{Faces, Mesh, Rules, Vec3, refine, shapes};

/// A mesh, its faces as a plain list, and targets that are not smooth.
pub(crate) struct Subject {
    pub(crate) name: &'static str,
    pub(crate) mesh: Mesh,
    pub(crate) faces: Faces,
    pub(crate) target: Vec<Vec3>,
}

/// A torus row by row, a sphere in the order of subdivision, and the same sphere with vertices and
/// faces in random order.
pub(crate) fn subjects(side: u32, levels: u32) -> Vec<Subject> {
    let torus = shapes::torus(side, side);
    let sphere = refine::refine_mesh(&shapes::icosahedron(), &Rules::LOOP, levels)
        .expect("an icosahedron can be refined")
        .0;
    let (torus, sphere) = (subject("torus", torus), subject("sphere", sphere));
    let shuffled = shuffled("shuffled", &sphere);
    vec![torus, sphere, shuffled]
}

fn subject(name: &'static str, mesh: Mesh) -> Subject {
    let points = mesh.positions();
    let h = mesh.topology().halfedges().next().expect("there are faces");
    let edge =
        points[mesh.topology().origin(h).index()] - points[mesh.topology().target(h).index()];
    let mut random = Random(1);
    let noise = 0.1 * edge.length();
    let target = points
        .iter()
        .map(|&p| p + noise * Vec3::new(random.unit(), random.unit(), random.unit()))
        .collect();
    Subject { name, faces: mesh.topology().to_faces(), target, mesh }
}

/// The same mesh with vertices and faces in random order.
fn shuffled(name: &'static str, subject: &Subject) -> Subject {
    let mut random = Random(2);
    let vertices = random.permutation(subject.target.len());
    let faces = random.permutation(subject.faces.len());
    let mut number = vec![0; vertices.len()];
    for (new, &old) in vertices.iter().enumerate() {
        number[old as usize] = new as u32;
    }
    let corners = faces.iter().flat_map(|&f| subject.faces.get(fairform::FaceId(f)));
    let faces = Faces::uniform(3, corners.map(|&v| number[v as usize]).collect());
    let gather = |values: &[Vec3]| vertices.iter().map(|&v| values[v as usize]).collect();
    let mesh = Mesh::new(gather(subject.mesh.positions()), &faces).expect("still a manifold");
    Subject { name, target: gather(&subject.target), faces, mesh }
}

/// `SplitMix64`: the same numbers on every machine.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number between −1 and 1.
    fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// The numbers below `len` in random order.
    fn permutation(&mut self, len: usize) -> Vec<u32> {
        let mut order: Vec<u32> = (0..len as u32).collect();
        for i in (1..len).rev() {
            order.swap(i, (self.next() % (i as u64 + 1)) as usize);
        }
        order
    }
}
