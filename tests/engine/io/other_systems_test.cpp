// Files on kernels and file systems that answer otherwise than a new Linux on ext4, and in programs
// with closed streams, limits and masks of their own.
#include <fcntl.h>
#include <pthread.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <cerrno>
#include <csignal>
#include <vector>

#include "base/caught.h"
#include "base/threads.h"
#include "io/descriptor.h"
#include "io/locks.h"
#include "io/machine.h"
#include "plait/error.h"
#include "plait/extend/directory.h"
#include "plait/extend/file.h"
#include "support/answering_operations.h"
#include "support/error_of.h"
#include "support/in_child.h"
#include "support/temporary_directory.h"

namespace plait::test {
namespace {

using Kind = FileOperation::Kind;

}  // namespace

TEST_CASE("Descriptors_WhereStandardStreamsAreClosed_AreAboveTheirNumbers") {
  const TemporaryDirectory here;
  for (int closed = 1; closed < 8; ++closed) {
    CAPTURE(closed);
    CHECK(in_child([&] {
      for (int stream = 0; stream < 3; ++stream)
        if ((closed >> stream & 1) != 0) ::close(stream);
      const auto is_free = [&](int stream) { return ::fcntl(stream, F_GETFD) < 0; };
      const Directory directory(here.path());
      File made(directory, "f" + std::to_string(closed), OpenMode::kCreate);
      File again(made.path(), OpenMode::kRead);
      const Directory above = directory.parent();
      bool right = directory.names().size() == static_cast<std::size_t>(closed);
      for (const int descriptor :
           {directory.descriptor(), made.descriptor(), again.descriptor(), above.descriptor()})
        right = right && descriptor >= kLowestDescriptor &&
                (::fcntl(descriptor, F_GETFD) & FD_CLOEXEC) != 0;
      {
        const StandardStreamsTaken taken;
        right = right && ::dup(directory.descriptor()) >= kLowestDescriptor;
      }
      // What the program closed is free again.
      for (int stream = 0; stream < 3; ++stream)
        right = right && is_free(stream) == ((closed >> stream & 1) != 0);
      return right;
    }));
  }
}

TEST_CASE("Lock_OnAFileSystemWithoutLocks_IsToldFromOneThatAnotherHas") {
  const TemporaryDirectory here;
  File file(here.path() / "f", OpenMode::kCreate), other(here.path() / "f", OpenMode::kReadWrite);
  // EBADF: NFS, for what is open only to be read, and so for every directory; EPERM: a filter of
  // system calls.
  for (const int error : {ENOLCK, ENOSYS, EOPNOTSUPP, 524, EBADF, EINVAL, EPERM}) {
    const AnsweringOperations hook(Kind::kLock, error);
    CAPTURE(error);
    CHECK(try_lock(file, true) == LockResult::kNoLocks);
    CHECK(error_of([&] { file.lock(false); }).code() == ErrorCode::kNotSupported);
  }
  {
    const AnsweringOperations hook(Kind::kLock, EIO);
    CHECK(error_of([&] { try_lock(file, true); }).code() == ErrorCode::kIo);
  }
  CHECK(try_lock(file, true) == LockResult::kTaken);
  CHECK(try_lock(other, false) == LockResult::kConflict);
}

TEST_CASE("SyncOfADirectory_ThatTheFileSystemDoesNotHave_IsNoError") {
  const TemporaryDirectory here;
  const Directory directory(here.path());
  for (const int error : {EINVAL, ENOSYS, EOPNOTSUPP}) {
    const AnsweringOperations hook(Kind::kSyncDirectory, error);
    directory.sync();
    CHECK(hook.answers() == 1);
  }
  const AnsweringOperations hook(Kind::kSyncDirectory, EIO);
  CHECK_THROWS_AS(directory.sync(), Error);
}

TEST_CASE("Preallocate_InterruptedWheneverItIsLong_EndsInPieces") {
  constexpr std::uint64_t kBytes = 8 << 20, kMostAtOnce = 1 << 20;
  const TemporaryDirectory here;
  File file(here.path() / "f", OpenMode::kCreate);
  {
    const AnsweringOperations hook([&](const FileOperation& operation) {
      return operation.kind == Kind::kPreallocate && operation.bytes > kMostAtOnce ? EINTR : 0;
    });
    file.preallocate(kBytes);
    CHECK(hook.answers() == 3);
  }
  CHECK(file.size() == kBytes);
  const AnsweringOperations always(Kind::kPreallocate, EINTR);
  file.preallocate(2 * kBytes);  // ends, and the bytes come with the writes
  CHECK(file.size() == kBytes);
}

TEST_CASE("Preallocate_OnAFileSystemThatCannot_DoesNothing") {
  const TemporaryDirectory here;
  File file(here.path() / "f", OpenMode::kCreate);
  for (const int error : {EOPNOTSUPP, EINVAL, ENOSYS, EPERM}) {
    const AnsweringOperations hook(Kind::kPreallocate, error);
    file.preallocate(1 << 20);
    CHECK(hook.answers() == 1);
  }
  const AnsweringOperations hook(Kind::kPreallocate, ENOSPC);
  CHECK(error_of([&] { file.preallocate(1 << 20); }).code() == ErrorCode::kNoSpace);
}

TEST_CASE("Write_PastTheLimitOfFiles_IsAnErrorAndNoSignal") {
  const TemporaryDirectory here;
  CHECK(in_child([&] {
    constexpr std::uint64_t kLimit = 8192;
    const rlimit limit{kLimit, kLimit};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    File file(here.path() / "f", OpenMode::kCreate);
    const std::array<std::byte, 4096> page{};
    file.write_at(4096, page);
    const auto is_refused = [&](const auto& call) {
      try {
        call();
        return false;
      } catch (const Error& error) {
        return std::string(error.what()).find("File too large") != std::string::npos;
      }
    };
    return is_refused([&] { file.write_at(4097, page); }) &&
           is_refused([&] { file.resize(kLimit + 1); }) &&
           is_refused([&] { file.preallocate(kLimit + 1); }) && file.size() == kLimit;
  }));
}

TEST_CASE("Files_AreMadeWithWhatTheUmaskAllows") {
  const TemporaryDirectory here;
  CHECK(in_child([&] {
    ::umask(0002);
    const File file(here.path() / "f", OpenMode::kCreate);
    struct stat status {};
    return ::fstat(file.descriptor(), &status) == 0 && (status.st_mode & 0777) == 0664;
  }));
}

TEST_CASE("AbsolutePath_InADirectoryThatIsGone_IsNotFound") {
  const TemporaryDirectory here;
  std::filesystem::create_directory(here.path() / "gone");
  CHECK(in_child([&] {
    std::filesystem::current_path(here.path() / "gone");
    std::filesystem::remove(here.path() / "gone");
    if (absolute_path("/a/b") != "/a/b") return false;
    try {
      static_cast<void>(absolute_path("b"));
      return false;
    } catch (const Error& error) {
      return error.code() == ErrorCode::kNotFound;
    }
  }));
}

TEST_CASE("Threads_OfTheLibrary_BlockAllSignalsButFaults") {
  sigset_t before, there, after;
  ::pthread_sigmask(SIG_SETMASK, nullptr, &before);
  start_thread("a thread", [&] { ::pthread_sigmask(SIG_SETMASK, nullptr, &there); }).join();
  ::pthread_sigmask(SIG_SETMASK, nullptr, &after);
  for (const int number : {SIGUSR1, SIGTERM, SIGINT, SIGALRM, SIGPROF, SIGXFSZ, SIGCHLD, SIGHUP}) {
    CAPTURE(number);
    CHECK(sigismember(&there, number) == 1);
    CHECK(sigismember(&after, number) == sigismember(&before, number));
  }
  for (const int fault : {SIGSEGV, SIGBUS, SIGFPE, SIGILL}) CHECK(sigismember(&there, fault) == 0);
}

TEST_CASE("ForcedUnwind_InAHandlerOfAllExceptions_GoesOn") {
  std::exception_ptr first;
  bool went_on = true;
  start_thread("a thread", [&] {
    try {
      ::pthread_exit(nullptr);
    } catch (...) {
      keep_first(first);
    }
    went_on = false;
  }).join();
  CHECK(went_on);
  CHECK(error_of([&] { std::rethrow_exception(first); }).code() == ErrorCode::kCancelled);
  start_thread("a thread", [&] {
    try {
      ::pthread_exit(nullptr);
    } catch (...) {
      first = caught_exception();
    }
    went_on = false;
  }).join();
  CHECK(went_on);
  try {
    throw Error(ErrorCode::kBusy, "busy");
  } catch (...) {
    CHECK(error_of([error = caught_exception()] { std::rethrow_exception(error); }).code() ==
          ErrorCode::kBusy);
  }
}

}  // namespace plait::test
