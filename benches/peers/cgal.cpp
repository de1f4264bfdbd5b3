// CGAL: 3D surface subdivision methods on a `Surface_mesh` with plain double coordinates.

#include "peer.hpp"

#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/subdivision_method_3.h>
#include <CGAL/version.h>

using Kernel = CGAL::Simple_cartesian<double>;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;
namespace params = CGAL::parameters;

static void subdivide(Mesh& mesh, std::string const& scheme, int levels) {
    auto steps = params::number_of_iterations(levels);
    if (scheme == "loop") {
        CGAL::Subdivision_method_3::Loop_subdivision(mesh, steps);
    } else if (scheme == "catmull-clark") {
        CGAL::Subdivision_method_3::CatmullClark_subdivision(mesh, steps);
    } else if (scheme == "doo-sabin") {
        CGAL::Subdivision_method_3::DooSabin_subdivision(mesh, steps);
    } else {
        peer::fail("no such scheme");
    }
}

static peer::Result<double> once(peer::Task const& task, peer::Laps& laps) {
    auto const& from = task.mesh;
    Mesh mesh;
    mesh.reserve(from.vertex_count(), from.corners.size() / 2 + from.vertex_count(),
                 from.face_count());
    for (int v = 0; v < from.vertex_count(); v++) {
        double const* p = &from.points[3 * v];
        mesh.add_vertex({p[0], p[1], p[2]});
    }
    std::vector<Mesh::Vertex_index> face;
    int const* corner = from.corners.data();
    for (int size : from.sizes) {
        face.clear();
        for (int i = 0; i < size; i++) face.emplace_back(*corner++);
        mesh.add_face(face);
    }
    laps.lap();
    subdivide(mesh, task.scheme, task.levels);
    laps.lap();
    if (mesh.has_garbage()) mesh.collect_garbage();
    peer::Result<double> result(mesh.number_of_vertices(), mesh.number_of_faces(),
                                mesh.number_of_halfedges());
    double* point = result.points.get();
    for (auto v : mesh.vertices()) {
        auto const& p = mesh.point(v);
        for (int i = 0; i < 3; i++) *point++ = p[i];
    }
    int* to = result.corners.get();
    for (auto f : mesh.faces()) {
        for (auto v : mesh.vertices_around_face(mesh.halfedge(f))) *to++ = static_cast<int>(v);
    }
    laps.lap();
    return result;
}

int main(int argc, char** argv) {
    return peer::run(peer::task(argc, argv), "CGAL " CGAL_STR(CGAL_VERSION), once);
}
