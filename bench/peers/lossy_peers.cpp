#include "peers/lossy_peers.h"

#if defined(PLAIT_BENCH_ZFP)
#include <zfp.h>
#endif
#if defined(PLAIT_BENCH_DRACO)
#include <draco/compression/decode.h>
#include <draco/compression/encode.h>
#endif

namespace plait::bench {
namespace {

#if defined(PLAIT_BENCH_ZFP)
/// One 2-D stream for each component of each level.
LossySize zfp_size(const LossyMesh& mesh, double tolerance) {
  LossySize size;
  std::vector<float> back = mesh.numbers;
  for (const LossyMesh::Grids& grids : mesh.grids) {
    const std::size_t count = grids.side * grids.side * grids.count;
    std::vector<float> numbers(count);
    for (std::size_t component = 0; component < 3; ++component) {
      const auto place = [&](std::size_t i) { return 3 * (grids.first + i) + component; };
      for (std::size_t i = 0; i < count; ++i) numbers[i] = mesh.numbers[place(i)];
      zfp_field* const field =
          zfp_field_2d(numbers.data(), zfp_type_float, grids.side, grids.side * grids.count);
      zfp_stream* const stream = zfp_stream_open(nullptr);
      zfp_stream_set_accuracy(stream, tolerance);
      std::vector<unsigned char> to(zfp_stream_maximum_size(stream, field));
      bitstream* const bits = stream_open(to.data(), to.size());
      zfp_stream_set_bit_stream(stream, bits);
      zfp_stream_rewind(stream);
      size.bytes += zfp_compress(stream, field);
      zfp_stream_rewind(stream);
      zfp_decompress(stream, field);
      stream_close(bits);
      zfp_stream_close(stream);
      zfp_field_free(field);
      for (std::size_t i = 0; i < count; ++i) back[place(i)] = numbers[i];
    }
  }
  size.bytes += 12 * mesh.grids.front().first;  // the base vertices
  size.largest_error = largest_error(mesh.numbers, back);
  return size;
}

LossyPeer zfp() {
  return {"zfp, accuracy, 2-D", [](const LossyMesh& mesh, double bound) {
            // It takes the power of two below the tolerance.
            for (double tolerance = 16 * bound; tolerance > bound / 64; tolerance /= 2)
              if (const LossySize size = zfp_size(mesh, tolerance); size.largest_error <= bound)
                return std::optional(size);
            return std::optional<LossySize>();
          }};
}
#endif

#if defined(PLAIT_BENCH_DRACO)
void fill_draco_mesh(const LossyMesh& mesh, draco::Mesh& made) {
  made.set_num_points(static_cast<std::uint32_t>(mesh.numbers.size() / 3));
  draco::GeometryAttribute position;
  position.Init(draco::GeometryAttribute::POSITION, nullptr, 3, draco::DT_FLOAT32, false, 12, 0);
  const int id = made.AddAttribute(position, true, made.num_points());
  for (std::uint32_t i = 0; i < made.num_points(); ++i)
    made.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(i),
                                          &mesh.numbers[std::size_t{3} * i]);
  made.SetNumFaces(mesh.triangles.size());
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i)
    made.SetFace(draco::FaceIndex(i),
                 {draco::PointIndex(mesh.triangles[i][0]), draco::PointIndex(mesh.triangles[i][1]),
                  draco::PointIndex(mesh.triangles[i][2])});
}

std::optional<draco::EncoderBuffer> draco_encode(const draco::Mesh& mesh, int method, int bits,
                                                 int speed) {
  draco::Encoder encoder;
  encoder.SetEncodingMethod(method);
  encoder.SetSpeedOptions(speed, speed);
  encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, bits);
  draco::EncoderBuffer buffer;
  if (!encoder.EncodeMeshToBuffer(mesh, &buffer).ok()) return {};
  return buffer;
}

/// The largest error of quantisation to so many bits.
double draco_error(const LossyMesh& mesh, const draco::Mesh& made, int bits) {
  const auto buffer = draco_encode(made, draco::MESH_SEQUENTIAL_ENCODING, bits, 10);
  if (!buffer) return INFINITY;
  draco::DecoderBuffer input;
  input.Init(buffer->data(), buffer->size());
  auto decoded = draco::Decoder().DecodeMeshFromBuffer(&input);
  if (!decoded.ok()) return INFINITY;
  const draco::PointAttribute* const position =
      decoded.value()->GetNamedAttribute(draco::GeometryAttribute::POSITION);
  std::vector<float> back(mesh.numbers.size());
  for (std::uint32_t i = 0; i < back.size() / 3; ++i)
    position->GetMappedValue(draco::PointIndex(i), &back[std::size_t{3} * i]);
  return largest_error(mesh.numbers, back);
}

LossyPeer draco_peer() {
  return {"Draco, edgebreaker, speed 0", [](const LossyMesh& mesh, double bound) {
            draco::Mesh made;
            fill_draco_mesh(mesh, made);
            for (int bits = 8; bits <= 30; ++bits) {
              const double error = draco_error(mesh, made, bits);
              if (error > bound) continue;
              const auto buffer = draco_encode(made, draco::MESH_EDGEBREAKER_ENCODING, bits, 0);
              if (buffer) return std::optional(LossySize{buffer->size(), error});
            }
            return std::optional<LossySize>();
          }};
}
#endif

}  // namespace

std::vector<LossyPeer> lossy_peers() {
  std::vector<LossyPeer> peers;
#if defined(PLAIT_BENCH_ZFP)
  peers.push_back(zfp());
#endif
#if defined(PLAIT_BENCH_DRACO)
  peers.push_back(draco_peer());
#endif
  return peers;
}

}  // namespace plait::bench
