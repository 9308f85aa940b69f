// The faces of a base mesh as the file view has them: a byte for each face, and distances for the
// corners that the byte does not tell. docs/format.md, "view".
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "plait/base_mesh.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

struct ViewFaces {
  std::vector<std::byte> classes;        ///< [face]
  std::vector<std::uint32_t> distances;  ///< of the far corners, in their order
  std::vector<VertexId> vertices;        ///< [place]: in the order in which corners name them
};

ViewFaces pack_view_faces(const BaseMesh& mesh);

PLAIT_END_NAMESPACE
