// support/test_meshes.h: a few tiny meshes with names, each with the reason why it exists.
// Coordinates are exact in float32, so that a kernel in float and the oracle in double start from
// the same surface.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "plait/base_mesh.h"
#include "support/naive_subdivision.h"

namespace plait::test {

// Closed.

/// Valence 3 everywhere: in every stencil, vertices occur more than once.
IndexedMesh tetrahedron();
/// Valence 4 everywhere. Opposite vertices cancel out, so Loop's results can be computed by hand.
IndexedMesh octahedron();
/// Valence 5 everywhere. Its few faces allow tests with very deep levels.
IndexedMesh icosahedron();
/// The torus with the fewest vertices (Moebius, Csaszar). All seven vertices are regular and
/// neighbours of each other. Positions are in general position, and the surface crosses itself.
IndexedMesh seven_vertex_torus();
/// A torus of columns x rows vertices, all regular. REQUIRES: both at least 3.
IndexedMesh torus_grid(std::uint32_t columns, std::uint32_t rows);
/// Two vertices of valence n, both neighbours of n vertices of valence 4. REQUIRES: n >= 3.
IndexedMesh bipyramid(std::uint32_t n);
/// A triangle and its back: three interior vertices of valence 2, which no other closed mesh has.
/// The mesh is flat, so its normals have no meaning, and closed_meshes() does not contain it.
IndexedMesh two_faces_back_to_back();

// With border.

/// The smallest mesh: no interior edge, every corner of border valence 2.
IndexedMesh single_triangle();
/// One interior edge. All four wings of its Butterfly stencil are missing.
IndexedMesh two_triangles();
/// n triangles around vertex 0, which is on the border and has n + 1 neighbours.
IndexedMesh open_fan(std::uint32_t n);
/// n triangles around vertex 0, an inner vertex of valence n. All its neighbours are on the border.
IndexedMesh closed_fan(std::uint32_t n);
/// columns x rows squares, each divided into two triangles, on a wavy surface: regular inside, with
/// border valences 2, 3 and 4.
IndexedMesh sheet(std::uint32_t columns, std::uint32_t rows);
/// A cube of side n, each of its sides n x n squares: sharp edges and corners.
IndexedMesh cube_grid(std::uint32_t n);
/// A ring of n squares: two border loops, genus 0, no interior vertex. REQUIRES: n >= 3.
IndexedMesh annulus(std::uint32_t n);
/// A tetrahedron and a sheet: two components, one closed and one open.
IndexedMesh two_components();

// Random meshes from a seed. `edits` random edge flips, edge splits and face splits make valences
// of 3 and more (on the border 2 and more). Then vertices, faces and face corners are shuffled, so
// that edge frames and vertex orders occur in all combinations. The same seed gives the same mesh
// on every platform.

IndexedMesh random_sphere(std::uint64_t seed, std::uint32_t edits);
IndexedMesh random_torus(std::uint64_t seed, std::uint32_t edits);
IndexedMesh random_sheet(std::uint64_t seed, std::uint32_t edits);

struct NamedMesh {
  std::string name;
  IndexedMesh mesh;
};
/// The closed meshes above, each with a few parameters and seeds.
std::vector<NamedMesh> closed_meshes();
/// The meshes with border.
std::vector<NamedMesh> border_meshes();
/// All of them.
std::vector<NamedMesh> all_meshes();

/// Combines the meshes to one. Each keeps its own vertices, and they are placed side by side along
/// x.
IndexedMesh side_by_side(const std::vector<IndexedMesh>& meshes);

/// The same mesh for the oracle.
naive::Mesh to_naive(const IndexedMesh& mesh);

}  // namespace plait::test
