// plait: slots in the levels of a store. A patch is read as a program reads it, in the order of its
// rows, and not slot by slot.
#include <optional>

#include "micro/support.h"
#include "peers/slot_store.h"
#include "plait/extend/store_access.h"
#include "plait/reader.h"

namespace plait::bench {
namespace {

const std::vector<std::string> kNames = {"position", "normal"};

class PlaitSlots final : public SlotStore {
 public:
  PlaitSlots(const SlotPlace& place, const std::string& backend)
      : sizes_(place.sizes), path_(place.directory / "slots.plait"), budget_(place.cache_bytes) {
    if (std::filesystem::exists(path_)) return;
    StoreOptions options;
    options.backend = backend;
    options.budget_bytes = budget_;
    store_ = Store::create(path_, place.base, options, default_backends());
    for (std::uint32_t attribute = 0; attribute < sizes_.attributes; ++attribute)
      store_->add_attribute({kNames.at(attribute), ComponentType::kFloat32, 3},
                            static_cast<int>(sizes_.levels));
  }

  void load(const FillSlot& fill) override {
    {
      Session session = StoreAccess::open_session(*store_, {.only_writes = true});
      for (SlotKey key; key.attribute < sizes_.attributes; ++key.attribute)
        for (key.level = 1; key.level <= sizes_.levels; ++key.level) {
          LevelFile& file = level_of(key);
          for (std::uint64_t block = 0; block < file.geometry.block_count(); ++block) {
            const PinnedBlock pinned = session.pin(file, block, Access::kOverwrite);
            for (key.edge = file.geometry.first_edge(block);
                 key.edge < file.geometry.edge_after(block); ++key.edge)
              fill(key, slot_of(file, block, pinned, key.edge));
          }
        }
    }
    store_->commit();
  }
  void read(FaceId face, std::span<const SlotKey>, std::span<std::byte> into) override {
    if (!reader_) {
      store_ = Store::open(path_, {.budget_bytes = budget_}, default_backends());
      reader_.emplace(*store_);
    }
    const PatchView patch = reader_->read_patch(face, static_cast<int>(sizes_.levels));
    for (std::uint32_t attribute = 0; attribute < sizes_.attributes; ++attribute) {
      const RecordView records = patch.records(kNames[attribute]);
      const std::size_t bytes =
          patch_vertex_count(std::int64_t{1} << sizes_.levels) * records.record_bytes();
      records.copy_to(into.first(bytes));
      into = into.subspan(bytes);
    }
  }
  void change(std::span<const SlotKey> keys, const FillSlot& fill) override {
    if (!store_ || reader_) {
      reader_.reset();
      store_ = Store::open(path_, {.writable = true, .budget_bytes = budget_}, default_backends());
    }
    {
      Session session = StoreAccess::open_session(*store_);
      // All of them are read together, as other programs would ask for them.
      for (const SlotKey& key : keys) {
        const LevelFile& file = level_of(key);
        session.read_ahead(file, file.geometry.block_of(key.edge));
      }
      for (const SlotKey& key : keys) {
        LevelFile& file = level_of(key);
        const std::uint64_t block = file.geometry.block_of(key.edge);
        const PinnedBlock pinned = session.pin(file, block, Access::kUpdate);
        fill(key, slot_of(file, block, pinned, key.edge));
      }
    }
    store_->commit();
  }

 private:
  LevelFile& level_of(const SlotKey& key) {
    return StoreAccess::level_file(*store_, key.attribute, static_cast<int>(key.level));
  }
  static std::span<std::byte> slot_of(const LevelFile& file, std::uint64_t block,
                                      const PinnedBlock& pinned, EdgeId edge) {
    const auto slot = file.geometry.slot(edge);
    return pinned.bytes().subspan(slot.offset - file.geometry.block_offset(block), slot.bytes);
  }

  SlotSizes sizes_;
  std::filesystem::path path_;
  std::uint64_t budget_;
  std::optional<Store> store_;
  std::optional<Reader> reader_;
};

}  // namespace

SlotEngine plait_slots(const std::string& backend) {
  return {"plait " + backend, [backend](const SlotPlace& place) {
            return std::make_unique<PlaitSlots>(place, backend);
          }};
}

}  // namespace plait::bench
