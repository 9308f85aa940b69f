// The floor: one file with all slots, in order. A crash leaves some of what was changed.
#include "peers/slot_store.h"
#include "plait/extend/file.h"

namespace plait::bench {
namespace {

class PlainSlots final : public SlotStore {
 public:
  explicit PlainSlots(const SlotPlace& place)
      : sizes_(place.sizes),
        file_(place.directory / "slots", std::filesystem::exists(place.directory / "slots")
                                             ? OpenMode::kReadWrite
                                             : OpenMode::kCreate) {}
  void load(const FillSlot& fill) override {
    std::vector<std::byte> bytes;
    std::uint64_t at = 0;
    const auto write = [&] {
      file_.write_at(at, bytes);
      at += bytes.size();
      bytes.clear();
    };
    sizes_.for_each([&](const SlotKey& key) {
      const std::size_t before = bytes.size();
      bytes.resize(before + SlotSizes::bytes(key.level));
      fill(key, std::span(bytes).subspan(before));
      if (bytes.size() >= (1u << 20)) write();
    });
    write();
    file_.sync();
  }
  void read(FaceId, std::span<const SlotKey> keys, std::span<std::byte> into) override {
    for (const SlotKey& key : keys) {
      const std::size_t bytes = SlotSizes::bytes(key.level);
      file_.read_at(sizes_.offset(key), into.first(bytes));
      into = into.subspan(bytes);
    }
  }
  void change(std::span<const SlotKey> keys, const FillSlot& fill) override {
    std::vector<std::byte> bytes;
    for (const SlotKey& key : keys) {
      bytes.resize(SlotSizes::bytes(key.level));
      fill(key, bytes);
      file_.write_at(sizes_.offset(key), bytes);
    }
    file_.sync();
  }

 private:
  SlotSizes sizes_;
  File file_;
};

}  // namespace

std::uint64_t SlotSizes::offset(const SlotKey& key) const {
  std::uint64_t records = 0;
  for (std::uint32_t level = 1; level <= levels; ++level)
    records += (key.attribute + (level < key.level ? 1 : 0)) * (bytes(level) * edges);
  return records + bytes(key.level) * key.edge;
}

SlotEngine plain_slots() {
  return {"plain file", [](const SlotPlace& place) { return std::make_unique<PlainSlots>(place); }};
}

}  // namespace plait::bench
