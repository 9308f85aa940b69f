#include "plait/digest.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <cstring>
#include <memory>
#include <utility>
#include <vector>

#include "plait/error.h"
#include "plait/sweep.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Hashes slots one after another and sums the hashes. Each thread has its own object.
class SlotHasher {
 public:
  SlotHasher() : state_(XXH3_createState()) {
    if (!state_) throw Error(ErrorCode::kOutOfMemory, "digest: no memory for the hash state");
  }

  void add(VertexId start, VertexId end, int level, const std::string& attribute,
           std::span<const std::byte> bytes) noexcept {
    const std::uint32_t head[3] = {std::min(start, end), std::max(start, end),
                                   static_cast<std::uint32_t>(level)};
    XXH3_128bits_reset(state_.get());
    XXH3_128bits_update(state_.get(), head, sizeof(head));
    XXH3_128bits_update(state_.get(), attribute.c_str(), attribute.size() + 1);
    XXH3_128bits_update(state_.get(), bytes.data(), bytes.size());
    const XXH128_hash_t hash = XXH3_128bits_digest(state_.get());
    add({hash.high64, hash.low64});
  }
  void add(const Digest& other) noexcept {
    sum_.low += other.low;
    sum_.high += other.high + (sum_.low < other.low ? 1 : 0);
  }
  const Digest& sum() const { return sum_; }

 private:
  struct Free {
    void operator()(XXH3_state_t* state) const { XXH3_freeState(state); }
  };
  std::unique_ptr<XXH3_state_t, Free> state_;
  Digest sum_;
};

}  // namespace

std::string Digest::to_string() const { return fmt::format("{:016x}{:016x}", high, low); }

Digest digest(Store& store, const DigestOptions& options) {
  if (options.level != -1 &&
      (options.level < store.base_level() || options.level > store.finest_level()))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("digest level {}: expected {} to {}", options.level, store.base_level(),
                            store.finest_level()));
  if (options.threads < 1 || options.threads > 1024)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("digest: {} threads, expected 1 to 1024", options.threads));
  const auto wanted = [&](int level) { return options.level == -1 || options.level == level; };
  std::vector<SlotHasher> hashers(static_cast<std::size_t>(options.threads));
  std::uint64_t total = 0, before = 0;
  for (const AttributeInfo& info : store.attributes())
    for (int level = store.base_level() + 1; level <= info.finest_level; ++level)
      if (wanted(level)) total += store.base().edge_count();

  const std::span<const Edge> edges = store.base().edges();
  for (AttributeId id = 0; id < store.attributes().size(); ++id) {
    const AttributeInfo& info = store.attributes()[id];
    const std::string& name = info.schema.name;
    const std::size_t record_bytes = info.schema.record_bytes();
    if (wanted(store.base_level())) {
      const std::span<const std::byte> records = std::as_const(store).base_bytes(id);
      for (VertexId vertex = 0; vertex < store.base().vertex_count(); ++vertex)
        hashers[0].add(vertex, vertex, store.base_level(), name,
                       records.subspan(vertex * record_bytes, record_bytes));
    }
    for (int level = store.base_level() + 1; level <= info.finest_level; ++level) {
      if (!wanted(level)) continue;
      SweepPass pass;
      pass.name = fmt::format("digest of '{}', level {}", name, level);
      pass.accesses = {{id, level, level, Access::kRead, Reach::kOwn}};
      pass.kernel = [&](const SweepView& view, EdgeId edge, int worker) {
        hashers[static_cast<std::size_t>(worker)].add(edges[edge].start, edges[edge].end, level,
                                                      name, view.slot(0, level, edge));
      };
      SweepOptions sweep_options;
      sweep_options.threads = options.threads;
      if (options.proceed)
        sweep_options.proceed = [&](std::uint64_t done, std::uint64_t) {
          return options.proceed(before + done, total);
        };
      sweep(store, pass, sweep_options);
      before += store.base().edge_count();
    }
  }
  for (std::size_t i = 1; i < hashers.size(); ++i) hashers[0].add(hashers[i].sum());
  return hashers[0].sum();
}

PLAIT_END_NAMESPACE
