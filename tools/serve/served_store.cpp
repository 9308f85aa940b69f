#include "serve/served_store.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "plait/extend/store_access.h"

namespace plait {
namespace {

std::string_view text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace

ServedStore::ServedStore(Store& store, const ProgressCallback& progress)
    : store_(store),
      view_(view_of(store, progress)),
      records_(viewed_files(store)),
      session_(StoreAccess::open_session(store, {.policy = EvictionPolicy::kClock})) {
  const std::string_view page = viewer_page();
  const File html{"text/html; charset=utf-8", page.size(), page};
  files_["/"] = html;
  files_["/index.html"] = html;
  const std::string binary = "application/octet-stream";
  files_["/view"] = {binary, view_.size(), text_of(view_)};
  for (const ViewedFile& file : records_) files_["/" + file.name] = {binary, file.bytes, {}, &file};
  // The last eight bytes of a view are the checksum of all others.
  for (std::size_t i = view_.size() - 8; i < view_.size(); ++i)
    tag_ += fmt::format("{:02x}", std::to_integer<int>(view_[i]));
}

const ServedStore::File* ServedStore::find(const std::string& path) const {
  const auto found = files_.find(path);
  return found == files_.end() ? nullptr : &found->second;
}

void ServedStore::read(const File& file, std::uint64_t offset, std::span<std::byte> into) const {
  if (file.records == nullptr) {
    std::memcpy(into.data(), file.text.data() + offset, into.size());
    return;
  }
  const auto [name, attribute, level, bytes] = *file.records;
  if (level == store_.base_level()) {
    std::memcpy(into.data(), store_.base_bytes(attribute).data() + offset, into.size());
    return;
  }
  const LevelFile& of = StoreAccess::level_file(store_, attribute, level);
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

}  // namespace plait
