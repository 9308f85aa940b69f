#include "maintenance/block_proof.h"

#include <algorithm>

#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

struct BlockProof::Model {
  explicit Model(const Directory& directory) : scratch(directory) {}

  const LevelFile* of = nullptr;
  const Directory& scratch;
  BlockTable table;
  std::unique_ptr<Volume> volume;
  std::unique_ptr<Backend> backend;

  ~Model() {
    backend.reset();
    scratch.remove_if_possible(kName);
  }
  static constexpr const char* kName = "sealed";
};

BlockProof::BlockProof(const RegisteredBackend& backend, UnpublishedDirectory& scratch)
    : backend_(backend), scratch_(scratch) {}

BlockProof::~BlockProof() = default;

std::unique_ptr<Volume> BlockProof::open_volume() const { return backend_.open({}); }

BlockProof::Model& BlockProof::model_of(const LevelFile& file, const AttributeSchema& schema) {
  if (model_ && model_->of == &file) return *model_;
  model_.reset();
  auto model = std::make_unique<Model>(scratch_.directory());
  model->of = &file;
  model->table = file.table;
  std::ranges::fill(model->table.entries(), BlockEntry{});
  model->volume = open_volume();
  model->backend = model->volume->open_level({model->scratch, Model::kName, OpenMode::kCreate,
                                              file.geometry, model->table, schema, file.pipeline});
  model_ = std::move(model);
  return *model_;
}

std::optional<std::span<const std::byte>> BlockProof::stored_bytes(const LevelFile& file,
                                                                   const AttributeSchema& schema,
                                                                   std::uint64_t block,
                                                                   std::span<const std::byte> raw) {
  const BlockEntry& expected = file.table[block];
  if (expected.encoding == BlockEncoding::kRaw)
    return file.table.matches(block, raw) ? std::optional(raw) : std::nullopt;
  if (expected.encoding == BlockEncoding::kNeverWritten) return std::nullopt;
  Model& model = model_of(file, schema);
  try {
    model.backend->write({block, 1}, raw);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kNotSupported) throw;
    return std::nullopt;  // the block is encoded from other blocks, so alone it proves nothing
  }
  const BlockEntry& found = model.table[block];
  if (found.encoding != expected.encoding || found.stored_bytes != expected.stored_bytes ||
      found.checksum != expected.checksum)
    return std::nullopt;
  stored_.resize(found.stored_bytes);
  File(model.scratch, Model::kName, OpenMode::kRead).read_at(found.offset, stored_);
  return stored_;
}

PLAIT_END_NAMESPACE
