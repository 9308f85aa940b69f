// ply_attributes.h: which properties of a PLY file together are an attribute.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "mesh/files/ply_header.h"
#include "plait/attribute.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

struct PlyAttribute {
  AttributeSchema schema;
  std::vector<std::size_t> properties;  ///< of the element; one for each component
};

/// The attributes of the element "vertex", without its position; `left_out` gets the names of
/// properties that are none (plait/extend/attributed_mesh.h).
std::vector<PlyAttribute> attributes_of(const PlyElement& vertices,
                                        std::vector<std::string>& left_out);
/// Those of the element "face": each scalar property is one. A store has at most 255.
std::vector<PlyAttribute> face_attributes_of(const PlyElement& faces,
                                             std::vector<std::string>& left_out);

PLAIT_END_NAMESPACE
