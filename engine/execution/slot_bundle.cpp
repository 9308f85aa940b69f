#include "execution/slot_bundle.h"

#include <algorithm>
#include <new>
#include <utility>

namespace plait {
namespace {

constexpr std::size_t kAlignment = 64;

std::size_t rounded(std::size_t bytes) { return (bytes + kAlignment - 1) / kAlignment * kAlignment; }

}  // namespace

BundleShape::BundleShape(const Store& store, std::span<const AttributeId> attributes, int finest)
    : levels(finest) {
  for (const AttributeId id : attributes) {
    const AttributeSchema& schema = store.attributes()[id].schema;
    Output& output = outputs.emplace_back();
    output.components = schema.components;
    output.component_bytes = component_bytes(schema.type);
    output.record_bytes = schema.record_bytes();
    output.stride = output.record_bytes == 12 ? 16 : output.record_bytes;
    output.offsets.assign(static_cast<std::size_t>(finest) + 1, 0);
    for (int level = 1; level <= finest; ++level) {
      output.offsets[static_cast<std::size_t>(level)] = bytes;
      bytes = rounded(bytes + slot_records(level) * output.stride);
    }
  }
}

void SlotBundles::FreeMemory::operator()(std::byte* memory) const {
  ::operator delete(memory, std::align_val_t(kAlignment));
}

std::byte* SlotBundles::of(EdgeId edge) {
  std::byte*& bundle = bundle_of_[edge];
  if (bundle) return bundle;
  if (vacant_.empty()) {
    slabs_.emplace_back(static_cast<std::byte*>(
        ::operator new(kSlabBundles * bundle_bytes_, std::align_val_t(kAlignment))));
    for (std::size_t i = kSlabBundles; i-- > 0;)
      vacant_.push_back(slabs_.back().get() + i * bundle_bytes_);
  }
  bundle = vacant_.back();
  vacant_.pop_back();
  return bundle;
}

void SlotBundles::give_back(EdgeId edge) {
  vacant_.push_back(std::exchange(bundle_of_[edge], nullptr));
}

}  // namespace plait
