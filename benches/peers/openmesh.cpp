// OpenMesh: its uniform subdividers, on a mesh of its own with nothing attached that they do not
// need. HOW is `32` for points in single precision, which is the library's default.

#include "peer.hpp"

#include <OpenMesh/Core/Mesh/PolyMesh_ArrayKernelT.hh>
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Tools/Subdivider/Uniform/CatmullClarkT.hh>
#include <OpenMesh/Tools/Subdivider/Uniform/LoopT.hh>

template <class Vec> struct Traits : OpenMesh::DefaultTraits {
    using Point = Vec;
    using Normal = Vec;
};

template <class Mesh, class Subdivider>
auto subdivided(peer::Task const& task, peer::Laps& laps) {
    using Point = typename Mesh::Point;
    using Real = typename Point::value_type;
    auto const& from = task.mesh;
    Mesh mesh;
    mesh.reserve(from.vertex_count(), from.corners.size() / 2 + from.vertex_count(),
                 from.face_count());
    std::vector<typename Mesh::VertexHandle> vertices, face;
    vertices.reserve(from.vertex_count());
    for (int v = 0; v < from.vertex_count(); v++) {
        double const* p = &from.points[3 * v];
        vertices.push_back(mesh.add_vertex(Point(Real(p[0]), Real(p[1]), Real(p[2]))));
    }
    int const* corner = from.corners.data();
    for (int size : from.sizes) {
        face.clear();
        for (int i = 0; i < size; i++) face.push_back(vertices[*corner++]);
        mesh.add_face(face);
    }
    laps.lap();
    Subdivider subdivide;
    subdivide.attach(mesh);
    subdivide(task.levels);
    subdivide.detach();
    laps.lap();
    std::size_t corner_count = mesh.n_halfedges();
    peer::Result<Real> result(mesh.n_vertices(), mesh.n_faces(), corner_count);
    std::memcpy(result.points.get(), mesh.points(), 3 * sizeof(Real) * mesh.n_vertices());
    int* to = result.corners.get();
    for (auto f : mesh.faces()) {
        for (auto v = mesh.cfv_iter(f); v.is_valid(); ++v) *to++ = v->idx();
    }
    laps.lap();
    return result;
}

template <class Vec> int run(peer::Task const& task) {
    using Tri = OpenMesh::TriMesh_ArrayKernelT<Traits<Vec>>;
    using Poly = OpenMesh::PolyMesh_ArrayKernelT<Traits<Vec>>;
    using Real = typename Vec::value_type;
    using Loop = OpenMesh::Subdivider::Uniform::LoopT<Tri, Real>;
    using CatmullClark = OpenMesh::Subdivider::Uniform::CatmullClarkT<Poly, Real>;
    // The macros that are to take the number apart do so at other places than it has them.
    std::string library = "OpenMesh " + std::to_string(OM_VERSION >> 16) + "." +
                          std::to_string(OM_VERSION >> 8 & 0xff);
    if (task.scheme == "loop") return peer::run(task, library, subdivided<Tri, Loop>);
    if (task.scheme == "catmull-clark") {
        return peer::run(task, library, subdivided<Poly, CatmullClark>);
    }
    peer::fail("no such scheme");
}

int main(int argc, char** argv) {
    auto task = peer::task(argc, argv);
    return task.how == "32" ? run<OpenMesh::Vec3f>(task) : run<OpenMesh::Vec3d>(task);
}
