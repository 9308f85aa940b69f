// A piece of a base mesh that is larger than memory: what the slots of a range of edges follow
// from, in arrays of its own, with numbers of its own. The numbers ascend as those of the mesh do,
// so every rule that looks at the order of numbers decides as it does in the mesh.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "plait/base_mesh.h"
#include "plait/extend/topology.h"
#include "plait/extend/vector3.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

struct MeshPiece {
  EdgeId first = 0, after = 0;  ///< the range, in numbers of the mesh
  /// The number in the piece of the edge `first`. Those of the others follow. Before and behind
  /// them come edges of their faces, and of the faces around the vertices of these.
  EdgeId edges_before = 0;
  std::vector<VertexId> vertices;          ///< [vertex of the piece] its number in the mesh
  std::vector<Vector3<double>> positions;  ///< [vertex of the piece]
  /// Vertices of the piece around which it has all faces: a walk around one of them may be taken.
  std::vector<VertexId> walkable;
  /// Vertices of the piece that are no other piece's (owner_of() of store/parts/part_store.h).
  std::vector<VertexId> own;

  // As in Topology, in numbers of the piece. An edge lacks sides that are of no face of the piece.
  std::vector<std::array<VertexId, 3>> faces;
  std::vector<std::array<EdgeId, 3>> face_edges;
  std::vector<Edge> edges;
  std::vector<FaceSide> vertex_corners;  ///< of walkable vertices; none of others
  std::vector<EdgeId> border_edges;

  EdgeId edges_after() const { return edges_before + (after - first); }
  Topology topology() const { return {faces, face_edges, edges, vertex_corners, border_edges}; }
};

/// Reads the piece of the edges [first, after), and gives back all pages that it has read. The
/// arrays agree in it as MeshPages::need_topology() checks. REQUIRES: first < after; nobody else
/// uses the pages of the mesh. Errors: kBudget if it has more faces than fit into
/// mesh.piece_bytes(); kCorruption, kIo.
MeshPiece take_piece(const BaseMesh& mesh, EdgeId first, EdgeId after);

/// The piece of the last edges before `after`: as many as fit into mesh.piece_bytes() with what an
/// executor has for them, `bytes_of_vertex` for each vertex of the piece and `bytes_of_half` for
/// each of the edges at its cut. Errors: as take_piece(); kBudget if one edge does not fit.
MeshPiece take_last_piece(const BaseMesh& mesh, EdgeId after, std::uint64_t bytes_of_vertex,
                          std::uint64_t bytes_of_half);

PLAIT_END_NAMESPACE
