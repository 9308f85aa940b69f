// What plait/extend/codec.h promises, checked on the codec alone: the backend stores a block raw
// when its codec fails to save enough, and so hides many mistakes.
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <memory>
#include <new>
#include <optional>
#include <random>
#include <span>
#include <string>

#include "conformance/suite.h"

namespace plait::conformance {
namespace {

constexpr std::size_t kSizes[] = {1, 12, 1000, 4096, 12288};
constexpr unsigned kMostSeconds = 120;  ///< for all damaged blocks together

/// Memory whose end, or whose beginning, is at a page that nobody may access.
class GuardedBytes {
 public:
  GuardedBytes(std::size_t bytes, bool at_end) {
    const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
    const std::size_t room = (bytes + page - 1) / page * page;
    mapped_bytes_ = room + 2 * page;
    mapped_ = ::mmap(nullptr, mapped_bytes_, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (mapped_ == MAP_FAILED) throw CheckEnded();
    std::byte* const first = static_cast<std::byte*>(mapped_) + page;
    if (room > 0 && ::mprotect(first, room, PROT_READ | PROT_WRITE) != 0) throw CheckEnded();
    bytes_ = {at_end ? first + room - bytes : first, bytes};
  }
  ~GuardedBytes() { ::munmap(mapped_, mapped_bytes_); }
  GuardedBytes(const GuardedBytes&) = delete;
  GuardedBytes& operator=(const GuardedBytes&) = delete;
  std::span<std::byte> bytes() const { return bytes_; }

 private:
  void* mapped_ = nullptr;
  std::size_t mapped_bytes_ = 0;
  std::span<std::byte> bytes_;
};

/// Content number `trial`: smooth, zeros, random, or smooth with few changed bits.
Bytes content_of(int trial, std::mt19937& random) {
  const std::size_t bytes = kSizes[random() % std::size(kSizes)];
  const auto seed = static_cast<std::uint32_t>(trial);
  if (trial % 10 == 9) return make_content(bytes, Content::kRandom, seed);
  if (trial % 10 == 8) return make_content(bytes, Content::kZeros, seed);
  Bytes content = make_content(bytes, Content::kSmooth, seed);
  for (std::uint32_t changes = random() % 4; changes > 0; --changes)
    content[random() % bytes] ^= static_cast<std::byte>(1u << random() % 8);
  return content;
}

std::optional<Bytes> encoded(Codec& codec, const Bytes& raw, bool whole) {
  // As the compressed backend asks: a block must save an eighth. Or with all the room there is.
  Bytes into(whole ? codec.bound(raw.size()) : raw.size() - raw.size() / 8);
  const std::optional<std::size_t> bytes = codec.compress(raw, into);
  if (!bytes) return std::nullopt;
  into.resize(std::min(*bytes, into.size()));
  return into;
}

/// `encoded` with a change: a bit, a byte, the end, or all of it.
Bytes damaged(Bytes encoded, std::mt19937& random) {
  switch (random() % 5) {
    case 0:
      if (!encoded.empty())
        encoded[random() % encoded.size()] ^= static_cast<std::byte>(1u << random() % 8);
      break;
    case 1:
      encoded.resize(random() % (encoded.size() + 1));
      break;
    case 2:
      for (std::size_t i = 0; i < std::min<std::size_t>(encoded.size(), 1 + random() % 8); ++i)
        encoded[i] = random() % 2 == 0 ? std::byte{0xff} : static_cast<std::byte>(random());
      break;
    case 3:
      for (std::byte& byte : encoded) byte = static_cast<std::byte>(random());
      break;
    default:
      if (encoded.size() > 4) {
        const std::size_t at = random() % (encoded.size() - 3);
        std::memset(&encoded[at], static_cast<int>(random() % 256), 4);
      }
  }
  return encoded;
}

/// What a child process tells its parent.
struct Progress {
  int trial = 0;
  int wrong_errors = 0;  ///< errors that are no kCorruption
};

void decode_damaged(Codec& codec, int blocks, Progress& progress) {
  std::mt19937 random(5);
  for (; progress.trial < blocks; ++progress.trial) {
    const Bytes raw = content_of(progress.trial, random);
    const std::optional<Bytes> whole = encoded(codec, raw, true);
    if (!whole) continue;
    const Bytes wrong = damaged(*whole, random);
    const bool at_end = random() % 4 != 0;
    const GuardedBytes stored(wrong.size(), at_end), into(raw.size(), at_end);
    std::ranges::copy(wrong, stored.bytes().begin());
    try {
      codec.decompress(stored.bytes(), into.bytes());
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kCorruption) ++progress.wrong_errors;
    } catch (...) {
      ++progress.wrong_errors;
    }
  }
}

std::string way_out(int status) {
  if (WIFSIGNALED(status) && WTERMSIG(status) == SIGALRM) return "it never ended";
  if (WIFSIGNALED(status)) return std::string("it ended by ") + strsignal(WTERMSIG(status));
  return "it ended the process";
}

bool leave_out(const Subject& subject, CheckLog& log) {
  if (subject.make_codec) return false;
  log.leave_out("the pipeline has no codec of a registry");
  return true;
}

}  // namespace

void check_codec_gives_back(const Subject& subject, CheckLog& log) {
  if (leave_out(subject, log)) return;
  const std::unique_ptr<Codec> codec = subject.make_codec(), other = subject.make_codec();
  std::mt19937 random(3);
  int coded = 0;
  for (int trial = 0; trial < subject.codec_blocks; ++trial) {
    const Bytes raw = content_of(trial, random);
    const std::optional<Bytes> stored = encoded(*codec, raw, trial % 2 == 0);
    if (!stored) continue;
    ++coded;
    log.at("block " + std::to_string(trial) + ", " + std::to_string(raw.size()) + " bytes");
    Bytes back(raw.size());
    try {
      (trial % 3 == 0 ? *other : *codec).decompress(*stored, back);
    } catch (const std::exception& error) {
      log.expect(false, std::string("a block that was encoded is decoded: ") + error.what());
      continue;
    }
    log.expect(back == raw, "a block that was encoded has every bit again");
  }
  log.at("");
  log.note(std::to_string(coded) + " of " + std::to_string(subject.codec_blocks) +
           " blocks were encoded");
  log.expect(coded > 0, "some blocks are encoded");
}

void check_codec_is_repeatable(const Subject& subject, CheckLog& log) {
  if (leave_out(subject, log)) return;
  const std::unique_ptr<Codec> used = subject.make_codec();
  std::mt19937 random(4);
  int compared = 0;
  for (int trial = 0; trial < subject.codec_blocks / 8; ++trial) {
    const Bytes raw = content_of(trial, random);
    const std::optional<Bytes> first = encoded(*used, raw, true), again = encoded(*used, raw, true),
                               fresh = encoded(*subject.make_codec(), raw, true);
    log.at("block " + std::to_string(trial));
    log.expect(first.has_value() == again.has_value() && first.has_value() == fresh.has_value(),
               "equal blocks are all encoded, or none of them");
    if (!first || !again || !fresh) continue;
    ++compared;
    log.expect(*first == *again && *first == *fresh,
               "equal blocks are encoded to equal bytes, so that copies of a store are equal");
  }
  log.note(std::to_string(compared) + " blocks were encoded three times");
}

void check_codec_stays_inside(const Subject& subject, CheckLog& log) {
  if (leave_out(subject, log)) return;
  void* const shared =
      ::mmap(nullptr, sizeof(Progress), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  log.require(shared != MAP_FAILED, "the machine gives a page of memory");
  auto& progress = *new (shared) Progress;
  const std::unique_ptr<Codec> codec = subject.make_codec();
  const ::pid_t child = ::fork();
  if (child == 0) {
    for (const int fatal : {SIGSEGV, SIGBUS, SIGABRT, SIGALRM}) ::signal(fatal, SIG_DFL);
    ::alarm(kMostSeconds);
    try {
      decode_damaged(*codec, subject.codec_blocks, progress);
    } catch (...) {
      ::_exit(1);
    }
    ::_exit(0);
  }
  log.require(child > 0, "the machine starts a process");
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  log.at("damaged block " + std::to_string(progress.trial) + ": " + way_out(status));
  log.expect(WIFEXITED(status) && WEXITSTATUS(status) == 0,
             "decompress() accesses no byte outside its spans, whatever is stored");
  log.at("");
  log.expect(progress.wrong_errors == 0,
             "decompress() refuses wrong bytes with kCorruption, and with no other error");
  log.note(std::to_string(progress.trial) + " damaged blocks were decoded");
  ::munmap(shared, sizeof(Progress));
}

}  // namespace plait::conformance
