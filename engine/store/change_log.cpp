#include "store/change_log.h"

#include <fmt/format.h>
#include <sys/mman.h>

#include <algorithm>
#include <cerrno>

#include "format/change_record.h"
#include "format/file_names.h"
#include "io/file_operations.h"
#include "io/system_call.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Disk space is taken in steps of this size: small steps would fragment the file, and each costs a
/// change of the file's metadata.
constexpr std::uint64_t kStepBytes = 16u << 20;

File open_log(const Directory& store, std::uint64_t generation, OpenMode mode) {
  if (mode == OpenMode::kCreate) store.remove(change_log_name(generation));
  return {store, change_log_name(generation), mode};
}

}  // namespace

class ChangeLog::Mapping {
 public:
  Mapping(const File& file, std::uint64_t bytes) : bytes_(bytes) {
    const int refused = before_operation({FileOperation::Kind::kMap, file.path()}).error;
    address_ = refused != 0 ? MAP_FAILED
                            : ::mmap(nullptr, bytes, PROT_READ, MAP_SHARED, file.descriptor(), 0);
    if (address_ == MAP_FAILED)
      throw system_error("map", file.path().native(), refused != 0 ? refused : errno);
  }
  ~Mapping() { ::munmap(address_, bytes_); }
  Mapping(const Mapping&) = delete;
  Mapping& operator=(const Mapping&) = delete;
  std::byte* at(std::uint64_t offset) const { return static_cast<std::byte*>(address_) + offset; }

 private:
  void* address_;
  std::uint64_t bytes_;
};

ChangeLog::ChangeLog(const Directory& store, std::uint64_t generation, OpenMode mode,
                     std::uint64_t bytes)
    : generation_(generation),
      file_(open_log(store, generation, mode)),
      committed_(bytes),
      end_(bytes),
      allocated_(file_.size()) {
  if (allocated_ < bytes)
    throw Error(ErrorCode::kCorruption, fmt::format("open {}: {} bytes, expected at least {}",
                                                    path().native(), allocated_, bytes))
        .about(path());
}

ChangeLog::~ChangeLog() = default;

std::uint64_t ChangeLog::end() const {
  const std::scoped_lock lock(mutex_);
  return end_;
}

std::uint64_t ChangeLog::append(std::span<const std::byte> bytes, std::uint64_t most) {
  std::uint64_t offset = 0;
  {
    const std::scoped_lock lock(mutex_);
    const std::uint64_t end = end_ + log_aligned(bytes.size());
    if (end > allocated_) {
      const std::uint64_t wanted = std::max(end, std::min(end + kStepBytes, most));
      file_.preallocate(wanted);
      allocated_ = wanted;
    }
    offset = std::exchange(end_, end);
  }
  file_.write_at(offset, bytes);
  return offset;
}

void ChangeLog::read(std::uint64_t offset, std::span<std::byte> into) {
  if (!mapping_ || into.data() != mapping_->at(offset)) return file_.read_at(offset, into);
  // What a disk cannot read is an error here, and no signal where the bytes are used.
  const FileOperation reading{FileOperation::Kind::kRead, path(), offset, into.size()};
  const ssize_t found = attempt(reading, [&](std::uint64_t) -> ssize_t {
#ifdef MADV_POPULATE_READ
    if (::madvise(into.data(), into.size(), MADV_POPULATE_READ) != 0 && errno != EINVAL) {
      if (errno == EFAULT || errno == EHWPOISON) errno = EIO;
      return -1;
    }
#endif
    return static_cast<ssize_t>(into.size());
  });
  if (found < 0) throw system_error("read", path().native(), errno, offset);
}

void ChangeLog::map() {
  if (!mapping_ && committed_ > 0) mapping_ = std::make_unique<Mapping>(file_, committed_);
}

std::byte* ChangeLog::address(std::uint64_t offset) const {
  if (!mapping_) return nullptr;
  // Access to a mapping beyond the end of its file kills the process (SIGBUS).
  if (const std::uint64_t found = file_.size(); found < committed_)
    throw Error(ErrorCode::kCorruption,
                fmt::format("access {}: expected at least {} bytes, found {}: the file was cut "
                            "short",
                            path().native(), committed_, found))
        .about(path(), found);
  return mapping_->at(offset);
}

void ChangeLog::roll_back() {
  const std::scoped_lock lock(mutex_);
  end_ = committed_;
}

PLAIT_END_NAMESPACE
