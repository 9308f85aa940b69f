#include "store/derived_attribute.h"

#include <fmt/format.h>

#include <utility>

#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

class DerivedLevel final : public Backend {
 public:
  DerivedLevel(const DerivedAttribute& attribute, const LevelGeometry& geometry, std::string name)
      : attribute_(attribute), geometry_(geometry), name_(std::move(name)) {}

  void read(BlockRange blocks, std::span<std::byte> into) override {
    if (blocks.count > geometry_.block_count() ||
        blocks.first > geometry_.block_count() - blocks.count ||
        into.size() != geometry_.range_bytes(blocks.first, blocks.count))
      throw Error(
          ErrorCode::kInvalidArgument,
          fmt::format("read {}: expected blocks below {} and their bytes, found {} from {} "
                      "and {} bytes",
                      name_, geometry_.block_count(), blocks.count, blocks.first, into.size()));
    for (std::uint64_t block = blocks.first; block < blocks.first + blocks.count; ++block) {
      const std::span<std::byte> raw = into.first(geometry_.block_bytes(block));
      into = into.subspan(raw.size());
      attribute_.deriver().make(geometry_, block, raw);
    }
  }
  void write(BlockRange, std::span<const std::byte>) override {
    throw Error(ErrorCode::kBadState,
                fmt::format("write {}: it is computed when it is read", name_));
  }
  void advise(BlockRange, Advice) noexcept override {}
  void sync(bool) override {}
  std::uint64_t stored_bytes() const override { return 0; }

 private:
  const DerivedAttribute& attribute_;
  const LevelGeometry& geometry_;
  std::string name_;  ///< for messages
};

}  // namespace

DerivedAttribute::DerivedAttribute(std::shared_ptr<const Derivations> rules, std::string derivation,
                                   AttributeSchema schema)
    : rules_(std::move(rules)),
      derivation_(std::move(derivation)),
      schema_(std::move(schema)),
      source_(rules_->source_of(derivation_, schema_)) {
  disconnect(fmt::format("it is computed from '{}', which the store does not have", source_));
}

void DerivedAttribute::connect(DerivationSource source) {
  source_levels_ = source.levels;
  base_bytes_ = source.mesh.vertex_corners.size() * schema_.record_bytes();
  deriver_ = rules_->open(derivation_, schema_, std::move(source));
  refusal_.clear();
  source_base_changed();
}

void DerivedAttribute::disconnect(std::string reason) {
  deriver_.reset();
  source_levels_.clear();
  refusal_ = std::move(reason);
  source_base_changed();
}

std::unique_ptr<Backend> DerivedAttribute::open_level(const LevelGeometry& geometry,
                                                      std::string name) const {
  return std::make_unique<DerivedLevel>(*this, geometry, std::move(name));
}

std::span<const std::byte> DerivedAttribute::base_records() const {
  const Deriver& from = deriver();
  const std::scoped_lock lock(base_mutex_);
  std::uint64_t state = changes_;
  for (const LevelFile* const level : source_levels_) state += level->changes;
  if (!has_base_ || state != base_state_) {
    has_base_ = false;
    base_.resize(base_bytes_);
    from.make_base(base_);
    base_state_ = state;
    has_base_ = true;
  }
  return base_;
}

const Deriver& DerivedAttribute::deriver() const {
  if (deriver_) return *deriver_;
  throw Error(ErrorCode::kBadState,
              fmt::format("read '{}', which is derived: {}", schema_.name, refusal_));
}

PLAIT_END_NAMESPACE
