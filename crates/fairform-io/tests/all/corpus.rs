//! Every file of `data/meshes` is read as its list of origins says, or refused with its place.
//!
//! The counts were made by another reader, in another language, before this crate was written.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use crate::common::meshes;
use fairform::Vec3;
use fairform_io::{Error, MeshData, read};

/// File, vertices, faces, and how many faces have so many corners.
const READABLE: &[(&str, usize, usize, &str)] = &[
    ("bad/all_faces_inward_cube.off", 8, 6, "4:6"),
    ("bad/back_to_back_triangles.off", 3, 2, "3:2"),
    ("bad/bowtie_open_fans.obj", 5, 2, "3:2"),
    ("bad/bowtie_vertex_two_tets.off", 7, 8, "3:8"),
    ("bad/comment_only.obj", 0, 0, ""),
    ("bad/declares_zero.off", 0, 0, ""),
    ("bad/declares_zero.ply", 0, 0, ""),
    ("bad/deep_exponent.obj", 3, 1, "3:1"),
    ("bad/degenerate_quad_repeated.obj", 8, 6, "4:6"),
    ("bad/degenerate_repeated_index.off", 4, 6, "3:6"),
    ("bad/denormal_coords.off", 8, 6, "4:6"),
    ("bad/duplicate_face.off", 4, 5, "3:5"),
    ("bad/duplicate_face_opposite.off", 4, 5, "3:5"),
    ("bad/face_missing_corner.obj", 3, 4, "0:1 1:1 2:1 3:1"),
    ("bad/forward_reference.obj", 3, 1, "3:1"),
    ("bad/huge_coords.off", 8, 6, "4:6"),
    ("bad/inconsistent_winding_cube.obj", 8, 6, "4:6"),
    ("bad/inf_coord.obj", 4, 4, "3:4"),
    ("bad/klein_bottle_quads.obj", 96, 96, "4:96"),
    ("bad/lines_only.glb", 0, 0, ""),
    ("bad/long_line.obj", 4, 4, "3:4"),
    ("bad/nan_coord.off", 4, 4, "3:4"),
    ("bad/nan_coord_binary.ply", 4, 4, "3:4"),
    ("bad/nan_coord_binary.stl", 4, 4, "3:4"),
    ("bad/nonmanifold_edge_3fans.obj", 5, 3, "3:3"),
    ("bad/nonmanifold_edge_two_cubes.off", 14, 12, "4:12"),
    ("bad/planar_cube.off", 8, 6, "4:6"),
    ("bad/points_and_lines_only.obj", 3, 0, ""),
    ("bad/polygon_visits_vertex_twice.obj", 6, 1, "7:1"),
    ("bad/soup_cube_ascii.stl", 8, 12, "3:12"),
    ("bad/soup_quads.obj", 24, 6, "4:6"),
    ("bad/soup_quads_jitter1e-7.off", 24, 6, "4:6"),
    ("bad/two_gon_and_one_gon.off", 4, 3, "1:1 2:1 3:1"),
    ("bad/unreferenced_vertices.ply", 6, 4, "3:4"),
    ("bad/vertices_only.off", 3, 0, ""),
    ("bad/zero_area_coincident.off", 4, 2, "3:2"),
    ("bad/zero_area_collinear.off", 6, 5, "3:5"),
    ("bad/zero_gon.off", 4, 2, "0:1 3:1"),
    ("bad/zero_length_mesh.off", 4, 4, "3:4"),
    ("bad_real/beetle_nonmanifold.obj", 1148, 2053, "3:2053"),
    ("bad_real/blobby_shuffled.off", 2027, 4050, "3:4050"),
    ("bad_real/box_longline_936gon.obj", 8, 6, "4:5 936:1"),
    ("bad_real/catmark_nonman_edges.obj", 142, 85, "3:1 4:84"),
    ("bad_real/catmark_nonman_verts.obj", 49, 20, "3:1 4:19"),
    ("bad_real/conrod_nonmanifold.off", 3223, 6442, "3:6442"),
    ("bad_real/cow_bowtie.obj", 2903, 5804, "3:5804"),
    ("bad_real/cube_minimal_degenerated.obj", 8, 14, "3:13 5:1"),
    ("bad_real/deg_faces.obj", 6, 4, "3:4"),
    ("bad_real/elephant_106loops.off", 2798, 4463, "3:4463"),
    ("bad_real/invalid_face_definition.obj", 8, 2, "1:1 2:1"),
    ("bad_real/loop_nonman_edges.obj", 96, 101, "3:101"),
    ("bad_real/loop_nonman_verts.obj", 39, 29, "3:29"),
    ("bad_real/moebius_quads.obj", 280, 224, "4:224"),
    ("bad_real/teapot_nonmanifold.obj", 3644, 6320, "3:6320"),
    ("odd/all_on_one_line.off", 4, 4, "3:4"),
    ("odd/coff.off", 4, 4, "3:4"),
    ("odd/colour_attribute_binary.stl", 8, 12, "3:12"),
    ("odd/comments_blank_lines.off", 4, 4, "3:4"),
    ("odd/comments_everywhere.obj", 8, 6, "4:6"),
    ("odd/concave_polygon.obj", 5, 1, "5:1"),
    ("odd/cr_only.obj", 8, 6, "4:6"),
    ("odd/crlf.obj", 8, 6, "4:6"),
    ("odd/crlf.off", 8, 6, "4:6"),
    ("odd/crlf_ascii.ply", 8, 6, "4:6"),
    ("odd/crlf_ascii.stl", 8, 12, "3:12"),
    ("odd/crlf_header_binary.ply", 8, 6, "4:6"),
    ("odd/cube.glb", 8, 12, "3:12"),
    ("odd/cube_embedded.gltf", 8, 12, "3:12"),
    ("odd/cube_no_indices.glb", 36, 12, "3:12"),
    ("odd/cube_node_transform.glb", 8, 12, "3:12"),
    ("odd/cube_stride20.glb", 8, 12, "3:12"),
    ("odd/cube_two_instances.glb", 16, 24, "3:24"),
    ("odd/cube_u32_indices.glb", 8, 12, "3:12"),
    ("odd/cube_u8_indices.glb", 8, 12, "3:12"),
    ("odd/double_binary.ply", 8, 6, "4:6"),
    ("odd/double_binary_be.ply", 8, 6, "4:6"),
    ("odd/extra_properties_ascii.ply", 4, 4, "3:4"),
    ("odd/extra_properties_binary.ply", 4, 4, "3:4"),
    ("odd/face_colours.off", 4, 4, "3:4"),
    ("odd/face_element_first.ply", 4, 4, "3:4"),
    ("odd/fan.glb", 5, 3, "3:3"),
    ("odd/freeform_skipped.obj", 4, 4, "3:4"),
    ("odd/groups_objects_materials.obj", 8, 6, "4:6"),
    ("odd/header_counts_one_line.off", 4, 4, "3:4"),
    ("odd/int_coords.ply", 8, 6, "4:6"),
    ("odd/latin1_comment.obj", 8, 6, "4:6"),
    ("odd/line_continuation.obj", 8, 6, "4:6"),
    ("odd/mixed_index_forms.obj", 8, 6, "4:6"),
    ("odd/negative_indices.obj", 8, 6, "4:6"),
    ("odd/negative_indices_interleaved.obj", 24, 6, "4:6"),
    ("odd/no_magic.off", 4, 4, "3:4"),
    ("odd/no_name_ascii.stl", 8, 12, "3:12"),
    ("odd/no_trailing_newline.obj", 8, 6, "4:6"),
    ("odd/no_trailing_newline.off", 8, 6, "4:6"),
    ("odd/no_trailing_newline.ply", 8, 6, "4:6"),
    ("odd/noff.off", 4, 4, "3:4"),
    ("odd/nonplanar_quads.off", 16, 9, "4:9"),
    ("odd/prism_24gon.off", 48, 26, "4:24 24:2"),
    ("odd/prism_300gon.obj", 600, 302, "4:300 300:2"),
    ("odd/prism_300gon_ushort.ply", 600, 302, "4:300 300:2"),
    ("odd/quads_and_triangles.off", 9, 9, "3:4 4:5"),
    ("odd/scientific.obj", 8, 6, "4:6"),
    ("odd/scientific.off", 8, 6, "4:6"),
    ("odd/short_indices.ply", 8, 6, "4:6"),
    ("odd/single_quad.obj", 4, 1, "4:1"),
    ("odd/single_triangle.off", 3, 1, "3:1"),
    ("odd/solid_in_binary_header.stl", 8, 12, "3:12"),
    ("odd/stoff.off", 3, 1, "3:1"),
    ("odd/strip.glb", 6, 4, "3:4"),
    ("odd/tabs_and_spaces.obj", 8, 6, "4:6"),
    ("odd/three_components.obj", 12, 12, "3:12"),
    ("odd/trailing_bytes_binary.stl", 8, 12, "3:12"),
    ("odd/tristrips.ply", 6, 4, "3:4"),
    ("odd/two_solids_ascii.stl", 8, 8, "3:8"),
    ("odd/type_aliases.ply", 8, 6, "4:6"),
    ("odd/uppercase_ascii.stl", 8, 12, "3:12"),
    ("odd/utf8_bom.obj", 8, 6, "4:6"),
    ("odd/utf8_bom.off", 8, 6, "4:6"),
    ("odd/utf8_names.obj", 8, 6, "4:6"),
    ("odd/v_slash_slash_vn.obj", 8, 6, "4:6"),
    ("odd/v_slash_vt.obj", 8, 6, "4:6"),
    ("odd/v_vt_vn.obj", 8, 6, "4:6"),
    ("odd/vertex_colours.obj", 8, 6, "4:6"),
    ("odd/vertex_list_property.ply", 4, 4, "3:4"),
    ("odd/vertex_w.obj", 8, 6, "4:6"),
    ("odd/zero_normals_binary.stl", 8, 12, "3:12"),
    ("odd_real/box_without_lineending.obj", 8, 6, "4:6"),
    ("odd_real/comments.off", 8, 6, "4:6"),
    ("odd_real/cube_binary_starts_with_nl.ply", 8, 6, "4:6"),
    ("odd_real/greg_turk_example2.ply", 8, 7, "3:2 4:5"),
    ("odd_real/platonic_shelf_faces_first_ascii.ply", 50, 50, "3:32 4:6 5:12"),
    ("odd_real/platonic_shelf_faces_first_le.ply", 50, 50, "3:32 4:6 5:12"),
    ("odd_real/rabbit_16gons.obj", 644, 678, "3:176 4:496 16:6"),
    ("odd_real/star_32gon.obj", 32, 1, "32:1"),
    ("polygon/cylinder_20gon_caps.obj", 220, 202, "4:200 20:2"),
    ("polygon/dodecahedron.obj", 20, 12, "5:12"),
    ("polygon/double_torus_3holes.off", 228, 201, "4:183 5:12 6:4 7:2"),
    ("polygon/double_torus_3to7gons.off", 231, 220, "4:202 5:12 6:4 7:2"),
    ("polygon/enneper_hexagons.off", 1920, 900, "6:900"),
    ("polygon/platonic_shelf.obj", 50, 50, "3:32 4:6 5:12"),
    ("polygon/platonic_shelf_be.ply", 50, 50, "3:32 4:6 5:12"),
    ("quad/catmark_bishop.obj", 917, 968, "3:132 4:836"),
    ("quad/catmark_pawn.obj", 601, 588, "4:588"),
    ("quad/catmark_torus.obj", 32, 32, "4:32"),
    ("quad/fandisk_quads.off", 766, 764, "4:764"),
    ("quad/fertility_quad.off", 3351, 3357, "4:3357"),
    ("quad/halftunnel_3loops.off", 831, 784, "4:784"),
    ("quad/horse_quad.obj", 2400, 2398, "4:2398"),
    ("quad/intersection_4loops.off", 1726, 1696, "3:64 4:1632"),
    ("quad/penguin_control.obj", 201, 221, "3:48 4:169 5:4"),
    ("quad/pipes_6loops.off", 32, 24, "4:24"),
    ("quad/quadknot.obj", 1440, 1440, "4:1440"),
    ("quad/spot_control.obj", 188, 180, "3:4 4:160 5:16"),
    ("quad/suzanne.obj", 507, 500, "3:32 4:468"),
    ("quad/teapot_quads_open.obj", 481, 448, "3:16 4:432"),
    ("quad/tubemesh_open.obj", 200, 171, "4:171"),
    ("tri_closed/anchor_val34.off", 519, 1050, "3:1050"),
    ("tri_closed/goathead.obj", 2763, 5522, "3:5522"),
    ("tri_closed/homer.off", 4930, 9856, "3:9856"),
    ("tri_closed/horse_3k.off", 3002, 6000, "3:6000"),
    ("tri_closed/icosahedron.off", 12, 20, "3:20"),
    ("tri_closed/knight_502.off", 502, 1000, "3:1000"),
    ("tri_closed/monkey.glb", 1966, 968, "3:968"),
    ("tri_closed/penguin_3k.obj", 3362, 6720, "3:6720"),
    ("tri_closed/rocker_arm_2500.obj", 2500, 5000, "3:5000"),
    ("tri_closed/sphere_soup_ascii.stl", 114, 224, "3:224"),
    ("tri_closed/spot.ply", 2930, 5856, "3:5856"),
    ("tri_closed/tetrahedron.off", 4, 4, "3:4"),
    ("tri_closed/thingi_65004_soup.stl", 731, 1466, "3:1466"),
    ("tri_closed/torus_2k.obj", 2304, 4608, "3:4608"),
    ("tri_open/cylinder_2loops.off", 930, 1800, "3:1800"),
    ("tri_open/face_mask_max.obj", 4486, 8743, "3:8743"),
    ("tri_open/hand_lowres_1loop.obj", 810, 1602, "3:1602"),
    ("tri_open/head_3loops.off", 1487, 2918, "3:2918"),
    ("tri_open/lego_1loop.ply", 1649, 3072, "3:3072"),
    ("tri_open/pipe6_tri.off", 428, 768, "3:768"),
    ("tri_open/snail_1loop.obj", 871, 1653, "3:1653"),
    ("valence/catmark_nonquads.obj", 33, 17, "3:7 4:7 5:1 6:2"),
    ("valence/catmark_pole64.obj", 129, 128, "3:64 4:64"),
    ("valence/catmark_val2_interior.obj", 103, 56, "4:50 5:4 6:2"),
    ("valence/catmark_xord_interior.obj", 151, 71, "4:71"),
    ("valence/loop_pole64.obj", 129, 192, "3:192"),
    ("valence/loop_xord_boundary.obj", 31, 23, "3:23"),
];

/// File, and what the error says behind the file's name.
const REFUSED: &[(&str, &str)] = &[
    (
        "bad/accessor_count_huge.glb",
        "a primitive brings 4000000000 vertices or corners, more than a file of this size may",
    ),
    (
        "bad/accessor_past_buffer_view.glb",
        "accessor 0 of 9 elements goes beyond its buffer view of 96 bytes",
    ),
    ("bad/base64_garbage.gltf", "buffer 0 is no base64 data: Invalid symbol 33, offset 0."),
    ("bad/buffer_view_missing.glb", "accessor 0 refers to buffer view 7, but the file has 2"),
    (
        "bad/count_too_big_binary.stl",
        "byte 684: the file declares 4000000000 triangles and ends after 12",
    ),
    (
        "bad/count_too_small_binary.stl",
        "byte 80: the file declares 5 triangles, but holds exactly 12",
    ),
    (
        "bad/deep_json.gltf",
        "line 1: the JSON is not glTF: invalid type: sequence, expected a string",
    ),
    ("bad/empty.glb", "the file is empty"),
    ("bad/empty.gltf", "the file is empty"),
    ("bad/empty.obj", "the file is empty"),
    ("bad/empty.off", "the file is empty"),
    ("bad/empty.ply", "the file is empty"),
    ("bad/empty.stl", "the file is empty"),
    ("bad/external_buffer_missing.gltf", "buffer 0: cannot read buffer 'missing.bin'"),
    (
        "bad/external_buffer_traversal.gltf",
        "buffer 0: buffer '../../../../outside.bin' is outside the folder of the file",
    ),
    ("bad/fewer_vertices_than_declared.off", "line 11: the file declares 4 faces and ends after 0"),
    ("bad/float_count.off", "line 2: found '3.0'; expected a vertex count"),
    ("bad/header_only.off", "line 2: the file ends here; expected a vertex count"),
    ("bad/html_named_ply.ply", "line 1: found '<!DOCTYPE'; expected 'ply' on the first line"),
    (
        "bad/huge_count.off",
        "line 2: the file declares 99999999999 vertices and 99999999999 faces, more than its 36 bytes can hold",
    ),
    (
        "bad/huge_face_count_binary.ply",
        "byte 227: the file declares 2147483647 faces and ends after 1",
    ),
    (
        "bad/huge_json_chunk.glb",
        "byte 12: a chunk of 4294967280 bytes, but the file holds 688 more",
    ),
    (
        "bad/huge_list_length_binary.ply",
        "byte 208: the file declares 1 face and ends after 0, and holds 3 of the 4294967295 numbers of a list",
    ),
    ("bad/huge_polygon.off", "line 6: face 0 of 2000000000 corners, more than the file can hold"),
    (
        "bad/huge_vertex_count_ascii.ply",
        "line 3: the file declares 1000000000000 vertices, too many",
    ),
    ("bad/huge_vertex_count_binary.ply", "line 3: the file declares 4294967295 vertices, too many"),
    (
        "bad/index_float.obj",
        "line 4: found '1.5'; expected a corner v, v/vt, v//vn or v/vt/vn of whole numbers",
    ),
    (
        "bad/index_huge.obj",
        "line 4: found '99999999999999999999'; expected a corner v, v/vt, v//vn or v/vt/vn of whole numbers",
    ),
    (
        "bad/index_negative.off",
        "line 11: face 4 lists vertex -1, but the mesh has 4 vertices, counted from 0",
    ),
    (
        "bad/index_negative_binary.ply",
        "byte 269: face 4 lists vertex -1, but the mesh has 4 vertices, counted from 0",
    ),
    ("bad/index_negative_too_far.obj", "line 4: vertex -7, but there are 3 so far"),
    ("bad/index_out_of_range.glb", "index 35 of accessor 1 is vertex 200, but the primitive has 8"),
    ("bad/index_out_of_range.obj", "line 9: vertex 10, but the file has 4"),
    (
        "bad/index_out_of_range.off",
        "line 11: face 4 lists vertex 4, but the mesh has 4 vertices, counted from 0",
    ),
    (
        "bad/index_out_of_range_binary.ply",
        "byte 269: face 4 lists vertex 1000000, but the mesh has 4 vertices, counted from 0",
    ),
    ("bad/index_zero.obj", "line 4: vertex index 0; the first is 1"),
    ("bad/locale_comma.obj", "line 1: found '0,5'; expected a number"),
    ("bad/locale_comma.off", "line 3: found '0,5'; expected a number"),
    ("bad/missing_z.ply", "element vertex has no property z; expected x, y and z"),
    ("bad/negative_count.off", "line 2: found '-4'; expected a vertex count"),
    ("bad/negative_count.ply", "line 3: found '-8'; expected a count"),
    ("bad/negative_list_length_binary.ply", "byte 203: a list of -3 numbers"),
    (
        "bad/no_vertex_element.ply",
        "line 6: face 0 lists vertex 0, but the mesh has 0 vertices, counted from 0",
    ),
    ("bad/node_cycle.glb", "node 0 is below itself or below two nodes; expected trees"),
    (
        "bad/not_a_mesh.obj",
        "line 1: found '\\u{0}\\u{1}\\u{2}\\u{3}\\u{4}\\u{5}\\u{6}\\u{7}\\u{8}'; a NUL byte is no text; expected an OBJ statement",
    ),
    ("bad/not_json.gltf", "line 1: the JSON is not glTF: EOF while parsing an object"),
    (
        "bad/nul_bytes.obj",
        "line 2: found '\\u{0}\\u{0}v'; a NUL byte is no text; expected an OBJ statement",
    ),
    (
        "bad/overflow_count.off",
        "line 2: found '18446744073709551617', too large; expected a vertex count",
    ),
    (
        "bad/png_named_off.off",
        "line 1: found '\\u{89}PNG'; expected OFF, COFF, NOFF, STOFF or a vertex count",
    ),
    ("bad/truncated.glb", "byte 8: the file declares 708 bytes and ends after 648"),
    ("bad/truncated.off", "line 14: the file declares 6 faces and ends after 3"),
    ("bad/truncated_ascii.stl", "line 41: the file ends within a facet"),
    ("bad/truncated_binary.stl", "byte 447: the file declares 12 triangles and ends after 7"),
    ("bad/truncated_faces_ascii.ply", "line 26: the file declares 12 faces and ends after 9"),
    (
        "bad/truncated_faces_binary.ply",
        "byte 397: the file declares 12 faces and ends after 10, and holds 1 of the 3 numbers of a list",
    ),
    ("bad/truncated_header.ply", "line 4: found 'propert'; expected a PLY header statement"),
    (
        "bad/truncated_vertices_binary.ply",
        "byte 210: the file declares 8 vertices and ends after 3",
    ),
    (
        "bad/unknown_format.ply",
        "line 2: found 'binary_middle_endian'; expected ascii, binary_little_endian or binary_big_endian",
    ),
    ("bad/unknown_type.ply", "line 5: found 'half'; expected a type, such as float"),
    ("bad/utf16_le.obj", "the text is UTF-16; expected UTF-8 or ASCII"),
    ("bad/version_1.glb", "byte 4: GLB version 1; expected 2"),
    ("bad/vertex_missing_component.obj", "line 1: 2 numbers after v; expected 3 numbers, x y z"),
    ("bad/whitespace_only.off", "the file holds only white space"),
    ("bad/word_for_number.ply", "line 13: found 'zero'; expected a number"),
    ("bad/wrong_total_length.glb", "byte 8: the file declares 99999999 bytes and ends after 708"),
    ("bad_real/invalid_relative_vertex_index.obj", "line 1: vertex -4, but there are 0 so far"),
    ("bad_real/test_nan.obj", "line 14: found '1.#IND'; expected a number"),
    ("bad_real/vertex_missing_star_2d.obj", "line 1: 2 numbers after v; expected 3 numbers, x y z"),
];

/// File, and a note of its reader.
const NOTED: &[(&str, &str)] = &[
    ("odd/tristrips.ply", "4 triangles made from 1 strip"),
    ("odd/trailing_bytes_binary.stl", "22 bytes behind the last triangle unread"),
    ("odd/two_solids_ascii.stl", "welded 24 corners into 8 vertices: STL has no connectivity"),
    ("odd/face_colours.off", "colours of 3 faces left out"),
    ("odd/freeform_skipped.obj", "6 free-form statements skipped"),
    ("bad/points_and_lines_only.obj", "2 point or line statements skipped: only faces are read"),
    (
        "bad/lines_only.glb",
        "1 primitive of points, lines or nothing skipped: only triangles are read",
    ),
    ("odd_real/star_32gon.obj", "passed over line 33: vn 1, but the file has 0"),
    ("odd/colour_attribute_binary.stl", "attribute bytes (colours) of 12 triangles left out"),
    (
        "odd/cube_no_indices.glb",
        "28 vertices at the position of another kept: glTF splits them at seams and sharp edges; welding joins them",
    ),
    ("odd/extra_properties_ascii.ply", "3 faces without texture coordinates have 0 0"),
];

fn summary(data: &MeshData) -> (usize, usize, String) {
    let mut sizes: BTreeMap<usize, usize> = BTreeMap::new();
    for face in data.faces.iter() {
        *sizes.entry(face.len()).or_default() += 1;
    }
    let kinds: Vec<_> = sizes.iter().map(|(size, count)| format!("{size}:{count}")).collect();
    (data.positions.len(), data.faces.len(), kinds.join(" "))
}

fn get(name: &str) -> MeshData {
    read(&meshes().join(name), None).unwrap_or_else(|e| panic!("{name}: {e}"))
}

#[test]
fn readable_files_have_the_counts_known_from_elsewhere() {
    for &(name, vertices, faces, kinds) in READABLE {
        let data = get(name);
        assert_eq!(summary(&data), (vertices, faces, kinds.to_string()), "{name}");
        let corners = data.faces.corners();
        assert!(corners.iter().all(|v| (*v as usize) < vertices), "{name}");
    }
}

#[test]
fn refused_files_say_where_and_why() {
    for &(name, expected) in REFUSED {
        let path = meshes().join(name);
        let error = read(&path, None).expect_err(name);
        assert!(matches!(error, Error::Parse { .. }), "{name}");
        let message = error.to_string();
        let rest = message.strip_prefix(&format!("{}: ", path.display())).expect("the file's name");
        assert!(rest.starts_with(expected), "{name}: {rest}");
    }
}

#[test]
fn notes_say_what_was_done() {
    for &(name, note) in NOTED {
        assert!(get(name).notes.iter().any(|n| n == note), "{name}: {:?}", get(name).notes);
    }
}

/// No file lies there that no test reads.
#[test]
fn every_file_is_in_a_table() {
    let mut listed: Vec<&str> = READABLE.iter().map(|row| row.0).collect();
    listed.extend(REFUSED.iter().map(|row| row.0));
    listed.sort_unstable();
    let mut found = Vec::new();
    for folder in fs::read_dir(meshes()).unwrap().map(|f| f.unwrap().path()).filter(|f| f.is_dir())
    {
        for file in fs::read_dir(folder).unwrap() {
            let path = file.unwrap().path();
            let name = path.strip_prefix(meshes()).unwrap().to_str().unwrap().replace('\\', "/");
            found.push(name);
        }
    }
    found.sort();
    assert_eq!(found, listed);
}

/// The same cube in every dialect: its box, and its first face where the order is kept.
#[test]
fn all_cubes_are_the_same_cube() {
    for &(name, vertices, faces, kinds) in READABLE.iter().filter(|row| row.0.starts_with("odd/")) {
        let transformed = name.contains("transform") || name.contains("instances");
        if (vertices, faces, kinds) != (8, 6, "4:6") || transformed {
            continue;
        }
        let data = get(name);
        let (low, high) = bounds(&data.positions);
        assert_eq!((low, high), (Vec3::splat(-1.0), Vec3::splat(1.0)), "{name}");
        assert_eq!(data.faces.iter().next(), Some(&[0, 3, 2, 1][..]), "{name}");
    }
}

fn bounds(positions: &[Vec3]) -> (Vec3, Vec3) {
    let first = positions[0];
    (
        positions.iter().copied().fold(first, Vec3::min),
        positions.iter().copied().fold(first, Vec3::max),
    )
}

/// Six times the volume inside a closed surface, by the divergence theorem.
fn volume(data: &MeshData) -> f64 {
    let p = |v: u32| data.positions[v as usize];
    let fan = |f: &[u32]| -> f64 {
        f.windows(2).skip(1).map(|w| p(f[0]).dot(p(w[0]).cross(p(w[1])))).sum()
    };
    data.faces.iter().map(fan).sum::<f64>() / 6.0
}

/// Two copies of one mesh enclose twice as much, whatever turns the nodes make of it.
#[test]
fn nodes_move_meshes_and_keep_them_outside_out() {
    assert!((volume(&get("odd/cube.glb")) - 8.0).abs() < 1e-12);
    assert!((volume(&get("odd/cube_two_instances.glb")) - 16.0).abs() < 1e-12);
    let moved = get("odd/cube_node_transform.glb");
    let (low, high) = bounds(&moved.positions);
    assert!((low.x - 8.0).abs() < 1e-6 && (high.x - 12.0).abs() < 1e-6, "{low:?} {high:?}");
    assert!(volume(&moved) > 0.0);
}

#[test]
fn attributes_come_through() {
    let colours = get("odd/coff.off").colours.unwrap();
    assert_eq!(colours[..1], [[1.0, 0.0, 0.0, 1.0]]);
    assert_eq!(colours[3..], [[9.0 / 255.0, 9.0 / 255.0, 9.0 / 255.0, 1.0]]);
    assert_eq!(get("odd/noff.off").normals.unwrap().len(), 4);
    assert_eq!(get("odd/stoff.off").uvs.unwrap(), [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
    assert_eq!(get("odd/vertex_colours.obj").colours.unwrap().len(), 8);
    let tags = get("odd/groups_objects_materials.obj");
    assert_eq!(tags.material_library.as_deref(), Some("none.mtl"));
    let groups = tags.groups.unwrap();
    assert_eq!(groups.names[5], "side5 all");
    assert_eq!(groups.of_face, [0, 1, 2, 3, 4, 5]);
    assert_eq!(tags.materials.unwrap().names, ["red"]);
    let solids = get("odd/two_solids_ascii.stl").groups.unwrap();
    assert_eq!(
        (solids.names, solids.of_face),
        (vec!["a".into(), "b b".into()], [[0; 4], [1; 4]].concat())
    );
    let extra = get("odd/extra_properties_ascii.ply");
    assert_eq!(extra.corner_uvs.unwrap()[..4], [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [0.0, 0.0]]);
    assert_eq!(extra.colours, None);
    assert!(get("quad/spot_control.obj").corner_uvs.is_some(), "a cow with a seam");
}

#[test]
fn numbers_that_are_not_finite_are_kept() {
    let not_finite = |name| get(name).positions.iter().filter(|p| !p.is_finite()).count();
    assert_eq!(not_finite("bad/nan_coord.off"), 1);
    assert_eq!(not_finite("bad/nan_coord_binary.ply"), 1);
    assert_eq!(not_finite("bad/nan_coord_binary.stl"), 1);
    assert_eq!(not_finite("bad/inf_coord.obj"), 3);
    assert_eq!(bounds(&get("bad/huge_coords.off").positions).1, Vec3::splat(1e30));
}

#[test]
fn the_error_of_a_missing_file_names_it() {
    let path = Path::new("no/such/file.obj");
    assert_eq!(read(path, None).unwrap_err().to_string(), "cannot read no/such/file.obj");
    let message = read(Path::new("mesh.xyz"), None).unwrap_err().to_string();
    assert!(message.starts_with("mesh.xyz: unknown format"), "{message}");
}
