// support/test_meshes.h: few, tiny, named meshes, each with the reason why it exists. Coordinates
// are exact in float32, so that a kernel in float and the oracle in double start from one surface.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "plait/base_mesh.h"
#include "support/naive_subdivision.h"

namespace plait::test {

// Closed.

/// Valence 3 everywhere: every stencil meets itself.
IndexedMesh tetrahedron();
/// Valence 4 everywhere; opposite vertices cancel, so Loop's results can be written by hand.
IndexedMesh octahedron();
/// Valence 5 everywhere; the tiny base of very deep stores.
IndexedMesh icosahedron();
/// The fewest vertices of a torus (Moebius, Csaszar): all seven are neighbours of each other, and
/// all regular. Positions are in general position, the surface crosses itself.
IndexedMesh seven_vertex_torus();
/// A torus of columns x rows vertices, all regular. REQUIRES: both at least 3.
IndexedMesh torus_grid(std::uint32_t columns, std::uint32_t rows);
/// Two vertices of valence n, both neighbours of n vertices of valence 4. REQUIRES: n >= 3.
IndexedMesh bipyramid(std::uint32_t n);
/// A triangle and its back: three interior vertices of valence 2, of which no other closed mesh has
/// one. Flat, so without normals that say anything, and not among closed_meshes().
IndexedMesh two_faces_back_to_back();

// With border.

/// The least mesh: no interior edge, every corner of border valence 2.
IndexedMesh single_triangle();
/// One interior edge, all four wings of whose Butterfly stencil are missing.
IndexedMesh two_triangles();
/// n triangles round vertex 0, which lies on the border with n + 1 neighbours.
IndexedMesh open_fan(std::uint32_t n);
/// n triangles all round vertex 0, inside, of valence n; all its neighbours are on the border.
IndexedMesh closed_fan(std::uint32_t n);
/// columns x rows squares cut in two, wavy: regular inside, border valences 2, 3 and 4.
IndexedMesh sheet(std::uint32_t columns, std::uint32_t rows);
/// A ring of n squares: two border loops, genus 0, no interior vertex. REQUIRES: n >= 3.
IndexedMesh annulus(std::uint32_t n);
/// A tetrahedron and a sheet: two components, one closed and one open.
IndexedMesh two_components();

// From a seed. `edits` random edge flips, edge splits and face splits make valences from 3 up
// (border 2 up); vertices, faces and face corners are then shuffled, so that edge frames and vertex
// orders fall in every way. The same seed gives the same mesh on every platform.

IndexedMesh random_sphere(std::uint64_t seed, std::uint32_t edits);
IndexedMesh random_torus(std::uint64_t seed, std::uint32_t edits);
IndexedMesh random_sheet(std::uint64_t seed, std::uint32_t edits);

struct NamedMesh {
  std::string name;
  IndexedMesh mesh;
};
/// The closed ones above, a few parameters and seeds each.
std::vector<NamedMesh> closed_meshes();
/// The ones with border.
std::vector<NamedMesh> border_meshes();
/// All of them.
std::vector<NamedMesh> all_meshes();

/// The same mesh for the oracle.
naive::Mesh to_naive(const IndexedMesh& mesh);

}  // namespace plait::test
