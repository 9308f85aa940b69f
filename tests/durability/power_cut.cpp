#include "durability/power_cut.h"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <string_view>
#include <utility>

namespace plait::test {
namespace {

namespace fs = std::filesystem;

/// Past the seam that this stands in.
std::vector<std::byte> content_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::vector<char> bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  std::vector<std::byte> result(bytes.size());
  if (!bytes.empty()) std::memcpy(result.data(), bytes.data(), bytes.size());
  return result;
}

}  // namespace

PowerCut::PowerCut(fs::path root, std::uint64_t seed, int per_operation,
                   std::function<std::uint64_t()> note)
    : root_(std::move(root)), random_(seed), per_operation_(per_operation), note_(std::move(note)) {
  // What is there already has been there for long.
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root_)) {
    if (entry.is_directory()) {
      names_[entry.path()] = {kDirectory};
      continue;
    }
    names_[entry.path()] = {adopt(entry.path())};
    make_durable(files_.back());
  }
  set_file_operation_hook(this);
}

PowerCut::~PowerCut() { set_file_operation_hook(nullptr); }

FileOperationHook::Verdict PowerCut::before(const FileOperation& operation) noexcept {
  if (is_harmless(operation.kind) || !concerns(operation.path)) return {};
  const std::scoped_lock lock(mutex_);
  ++operations_;
  look();
  cut();
  return without_waiting(operation);
}

void PowerCut::after(const FileOperation& operation) noexcept {
  using Kind = FileOperation::Kind;
  if (!concerns(operation.path)) return;
  const std::scoped_lock lock(mutex_);
  switch (operation.kind) {
    case Kind::kCreate:
    case Kind::kMakeDirectory:
    case Kind::kRemove: {
      std::vector<int>& states = names_[operation.path];
      if (states.empty()) states.push_back(kNothing);
      states.push_back(operation.kind == Kind::kRemove          ? kNothing
                       : operation.kind == Kind::kMakeDirectory ? kDirectory
                                                                : adopt(operation.path));
      break;
    }
    case Kind::kSync: {
      const auto name = names_.find(operation.path);
      if (name == names_.end() || name->second.back() < 0) break;
      // What another thread wrote meanwhile counts as written after it.
      make_durable(files_[static_cast<std::size_t>(name->second.back())]);
      break;
    }
    case Kind::kSyncDirectory:
      for (auto& [path, states] : names_)
        if (path.parent_path() == operation.path) states = {states.back()};
      break;
    default:
      break;
  }
}

bool PowerCut::concerns(const fs::path& path) const {
  return std::string_view(path.native()).starts_with(root_.native());
}

int PowerCut::adopt(const fs::path& path) {
  FileState& file = files_.emplace_back();
  file.sizes = {0};
  look_at(file, path);
  return static_cast<int>(files_.size() - 1);
}

void PowerCut::look() {
  for (const auto& [path, states] : names_)
    if (states.back() >= 0) look_at(files_[static_cast<std::size_t>(states.back())], path);
}

void PowerCut::look_at(FileState& file, const fs::path& path) {
  Bytes now = content_of(path);
  if (now.size() != file.latest.size()) file.sizes.push_back(now.size());
  for (std::size_t at = 0; at < now.size(); at += kSectorBytes) {
    Bytes after(kSectorBytes), before(kSectorBytes);
    std::memcpy(after.data(), &now[at], std::min(kSectorBytes, now.size() - at));
    if (at < file.latest.size())
      std::memcpy(before.data(), &file.latest[at], std::min(kSectorBytes, file.latest.size() - at));
    if (after == before) continue;
    std::vector<Bytes>& versions = file.sectors[at];
    if (versions.empty()) versions.push_back(before);
    versions.push_back(after);
  }
  file.latest = std::move(now);
}

void PowerCut::make_durable(FileState& file) {
  file.durable = file.latest;
  file.sizes = {file.latest.size()};
  file.sectors.clear();
}

std::size_t PowerCut::choose(std::size_t count, Choice choice) {
  if (choice == Choice::kOldest) return 0;
  if (choice == Choice::kNewest) return count - 1;
  return random_() % count;
}

void PowerCut::cut() {
  keep_outcome(Choice::kOldest);
  keep_outcome(Choice::kNewest);
  for (int i = 2; i < per_operation_; ++i) keep_outcome(Choice::kRandom);
}

void PowerCut::keep_outcome(Choice choice) {
  Outcome outcome{note_(), operations_, {"."}, {}};
  for (const auto& [path, states] : names_) {  // a directory comes before what is in it
    const int state = states[choose(states.size(), choice)];
    const fs::path name = path.lexically_relative(root_);
    const fs::path parent = name.has_parent_path() ? name.parent_path() : fs::path(".");
    if (state == kNothing || !outcome.directories.contains(parent)) continue;
    if (state == kDirectory) {
      outcome.directories.insert(name);
      continue;
    }
    FileState& file = files_[static_cast<std::size_t>(state)];
    Bytes bytes = file.durable;
    for (const auto& [at, versions] : file.sectors) {
      const Bytes& version = versions[choose(versions.size(), choice)];
      bytes.resize(std::max(bytes.size(), at + kSectorBytes));
      std::memcpy(&bytes[at], version.data(), kSectorBytes);
    }
    bytes.resize(file.sizes[choose(file.sizes.size(), choice)]);
    outcome.files[name] = *contents_.insert(std::make_shared<const Bytes>(std::move(bytes))).first;
  }
  const bool known = std::ranges::any_of(outcomes_, [&](const Outcome& other) {
    return other.note == outcome.note && other.files == outcome.files &&
           other.directories == outcome.directories;
  });
  if (!known) outcomes_.push_back(std::move(outcome));
}

void PowerCut::Outcome::put_into(const fs::path& directory) const {
  // Files are overwritten rather than made anew, which some file systems are slow at.
  for (auto entry = fs::recursive_directory_iterator(directory);
       entry != fs::recursive_directory_iterator(); ++entry)
    if (entry->is_regular_file() && !files.contains(entry->path().lexically_relative(directory)))
      fs::remove(entry->path());
  for (const fs::path& name : directories) fs::create_directories(directory / name);
  for (const auto& [name, bytes] : files)
    std::ofstream(directory / name, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes->data()),
               static_cast<std::streamsize>(bytes->size()));
}

}  // namespace plait::test
