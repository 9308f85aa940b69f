// A contiguous dataset of slots for each attribute and level in HDF5. A crash leaves some of what
// was changed.
#include <hdf5.h>
#include <unistd.h>

#include <array>
#include <utility>

#include "peers/slot_store.h"

namespace plait::bench {
namespace {

template <class Result>
Result check(Result result) {
  if (result < 0) refuse("hdf5", "a call failed");
  return result;
}

/// A number of HDF5, closed in the end.
class Handle {
 public:
  Handle(hid_t number, herr_t (*close)(hid_t)) : number_(check(number)), close_(close) {}
  Handle(Handle&& other) noexcept
      : number_(std::exchange(other.number_, -1)), close_(other.close_) {}
  ~Handle() {
    if (number_ >= 0) close_(number_);
  }
  operator hid_t() const { return number_; }

 private:
  hid_t number_;
  herr_t (*close_)(hid_t);
};

class Hdf5Slots final : public SlotStore {
 public:
  explicit Hdf5Slots(const SlotPlace& place) : sizes_(place.sizes), file_(file_of(place)) {
    const bool is_new = H5Lexists(file_, "0.1", H5P_DEFAULT) <= 0;
    for (std::uint32_t attribute = 0; attribute < sizes_.attributes; ++attribute)
      for (std::uint32_t level = 1; level <= sizes_.levels; ++level) {
        const std::string name = std::to_string(attribute) + "." + std::to_string(level);
        const std::array<hsize_t, 2> shape{sizes_.edges, SlotSizes::bytes(level)}, one{1, shape[1]};
        spaces_.emplace_back(H5Screate_simple(2, shape.data(), nullptr), H5Sclose);
        slots_.emplace_back(H5Screate_simple(2, one.data(), nullptr), H5Sclose);
        sets_.emplace_back(is_new
                               ? H5Dcreate2(file_, name.c_str(), H5T_NATIVE_UCHAR, spaces_.back(),
                                            H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT)
                               : H5Dopen2(file_, name.c_str(), H5P_DEFAULT),
                           H5Dclose);
      }
  }

  void load(const FillSlot& fill) override {
    SlotKey key;
    for (key.attribute = 0; key.attribute < sizes_.attributes; ++key.attribute)
      for (key.level = 1; key.level <= sizes_.levels; ++key.level) {
        const std::size_t bytes = SlotSizes::bytes(key.level);
        const std::uint32_t at_once = static_cast<std::uint32_t>((1u << 20) / bytes);
        std::vector<std::byte> run;
        for (std::uint32_t first = 0; first < sizes_.edges; first += at_once) {
          const std::uint32_t count = std::min(at_once, sizes_.edges - first);
          run.resize(count * bytes);
          for (key.edge = first; key.edge < first + count; ++key.edge)
            fill(key, std::span(run).subspan((key.edge - first) * bytes, bytes));
          const std::array<hsize_t, 2> shape{count, bytes};
          const Handle memory(H5Screate_simple(2, shape.data(), nullptr), H5Sclose);
          check(H5Dwrite(sets_[set_of(key)], H5T_NATIVE_UCHAR, memory,
                         selected({key.attribute, key.level, first}, count), H5P_DEFAULT,
                         run.data()));
        }
      }
    make_durable();
  }
  void read(FaceId, std::span<const SlotKey> keys, std::span<std::byte> into) override {
    for (const SlotKey& key : keys) {
      const std::size_t bytes = SlotSizes::bytes(key.level);
      check(H5Dread(sets_[set_of(key)], H5T_NATIVE_UCHAR, slots_[set_of(key)], selected(key, 1),
                    H5P_DEFAULT, into.data()));
      into = into.subspan(bytes);
    }
  }
  void change(std::span<const SlotKey> keys, const FillSlot& fill) override {
    std::vector<std::byte> bytes;
    for (const SlotKey& key : keys) {
      bytes.resize(SlotSizes::bytes(key.level));
      fill(key, bytes);
      check(H5Dwrite(sets_[set_of(key)], H5T_NATIVE_UCHAR, slots_[set_of(key)], selected(key, 1),
                     H5P_DEFAULT, bytes.data()));
    }
    make_durable();
  }

 private:
  static Handle file_of(const SlotPlace& place) {
    const std::string path = place.directory / "slots.h5";
    return {std::filesystem::exists(path)
                ? H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT)
                : H5Fcreate(path.c_str(), H5F_ACC_EXCL, H5P_DEFAULT, H5P_DEFAULT),
            H5Fclose};
  }
  std::size_t set_of(const SlotKey& key) const {
    return key.attribute * sizes_.levels + key.level - 1;
  }
  hid_t selected(const SlotKey& first, hsize_t count) const {
    const std::array<hsize_t, 2> start{first.edge, 0}, shape{count, SlotSizes::bytes(first.level)};
    const hid_t space = spaces_[set_of(first)];
    check(H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, shape.data(), nullptr));
    return space;
  }
  void make_durable() {
    check(H5Fflush(file_, H5F_SCOPE_GLOBAL));
    void* descriptor = nullptr;
    check(H5Fget_vfd_handle(file_, H5P_DEFAULT, &descriptor));
    if (::fdatasync(*static_cast<int*>(descriptor)) != 0) refuse("hdf5", "fdatasync failed");
  }

  SlotSizes sizes_;
  Handle file_;
  std::vector<Handle> spaces_, slots_, sets_;  ///< [set_of()]
};

}  // namespace

SlotEngine hdf5_slots() {
  return {"HDF5 " + std::to_string(H5_VERS_MAJOR) + "." + std::to_string(H5_VERS_MINOR),
          [](const SlotPlace& place) { return std::make_unique<Hdf5Slots>(place); }};
}

}  // namespace plait::bench
