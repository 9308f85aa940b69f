#include "format/packed_maps.h"

#include <utility>

#include "format/planes.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

std::vector<std::byte> pack_maps(const InputMaps& maps) {
  const std::size_t vertices = maps.input_vertices.size(), faces = maps.input_faces.size();
  std::vector<std::byte> packed(packed_maps_bytes(vertices, faces));
  const Planes<std::uint32_t> of_vertices(vertices), of_faces(faces);
  std::uint32_t last = 0;
  for (std::size_t v = 0; v < vertices; ++v)
    of_vertices.put(packed.data(), v,
                    zigzag(maps.input_vertices[v] - std::exchange(last, maps.input_vertices[v])));
  last = 0;
  for (std::size_t f = 0; f < faces; ++f) {
    const std::uint32_t code = 2 * maps.input_faces[f] + (maps.turned[f] ? 1 : 0);
    of_faces.put(packed.data() + of_vertices.bytes(), f, zigzag(code - std::exchange(last, code)));
  }
  return packed;
}

InputMaps unpack_maps(std::span<const std::byte> packed, std::uint64_t vertex_count,
                      std::uint64_t face_count, std::uint64_t input_vertex_count) {
  const Planes<std::uint32_t> of_vertices(vertex_count), of_faces(face_count);
  InputMaps maps;
  maps.input_vertices.resize(vertex_count);
  maps.input_faces.resize(face_count);
  maps.turned.resize(face_count);
  maps.input_vertex_count = input_vertex_count;
  std::uint32_t last = 0;
  of_vertices.for_each(packed.data(), [&](std::size_t v, std::uint32_t difference) {
    maps.input_vertices[v] = last += from_zigzag(difference);
  });
  last = 0;
  of_faces.for_each(packed.data() + of_vertices.bytes(),
                    [&](std::size_t f, std::uint32_t difference) {
                      last += from_zigzag(difference);
                      maps.input_faces[f] = last / 2;
                      maps.turned[f] = last % 2 != 0;
                    });
  return maps;
}

PLAIT_END_NAMESPACE
