#include "publish/served_store.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "plait/extend/store_access.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

std::string_view text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace

ServedStore::ServedStore(Store& store, const ProgressCallback& progress)
    : view_(view_of(store, progress)),
      reader_(store),
      session_(StoreAccess::open_session(store, {.policy = EvictionPolicy::kClock})) {
  const std::string_view page = viewer_page();
  const File html{"text/html; charset=utf-8", page.size(), page};
  files_["/"] = html;
  files_["/index.html"] = html;
  const std::string binary = "application/octet-stream";
  files_["/view"] = {binary, view_.size(), text_of(view_)};
  const Store& readable = store;
  for (const ViewedFile& file : viewed_files(store)) {
    File& served = files_['/' + file.name] = {binary, file.bytes};
    if (file.level == store.base_level())
      served.base = readable.base_bytes(file.attribute);
    else
      served.level = &StoreAccess::level_file(readable, file.attribute, file.level);
  }
  // The last eight bytes of a view are the checksum of all others.
  for (std::size_t i = view_.size() - 8; i < view_.size(); ++i)
    tag_ += fmt::format("{:02x}", std::to_integer<int>(view_[i]));
}

const ServedStore::File* ServedStore::find(const std::string& path) const {
  const auto found = files_.find(path);
  return found == files_.end() ? nullptr : &found->second;
}

void ServedStore::read(const File& file, std::uint64_t offset, std::span<std::byte> into) const {
  if (file.level == nullptr) {
    const std::byte* const whole =
        file.base.empty() ? reinterpret_cast<const std::byte*>(file.text.data()) : file.base.data();
    std::memcpy(into.data(), whole + offset, into.size());
    return;
  }
  const LevelFile& of = *file.level;
  while (!into.empty()) {
    const std::uint64_t block = of.geometry.block_at(offset);
    const PinnedBlock pinned = session_.pin(of, block);
    const std::uint64_t first = offset - of.geometry.block_offset(block);
    const std::span<const std::byte> there = pinned.bytes().subspan(first);
    const std::size_t count = std::min(into.size(), there.size());
    std::memcpy(into.data(), there.data(), count);
    into = into.subspan(count);
    offset += count;
  }
}

PLAIT_END_NAMESPACE
