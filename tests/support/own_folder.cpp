// Linked into every test program: temporary files of a process lie in a folder of its own, so that tests which run side
// by side and give a file the same name do not read each other's.
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

namespace {

namespace fs = std::filesystem;

class OwnFolder {
 public:
  OwnFolder() {
    // Other users may look into it, as into /tmp: a test becomes one.
    if (!::mkdtemp(name_.data()) || ::chmod(name_.data(), 0755) != 0) {
      std::perror(name_.data());
      std::abort();
    }
    ::setenv("TEST_TMPDIR", name_.data(), 1);  // testing::TempDir()
    ::setenv("TMPDIR", name_.data(), 1);       // std::filesystem::temp_directory_path() and what a test starts
  }
  ~OwnFolder() {
    std::error_code ignored;
    if (::getpid() == process_) fs::remove_all(name_.data(), ignored);  // a death test's child ends here too
  }
  OwnFolder(const OwnFolder&) = delete;
  OwnFolder& operator=(const OwnFolder&) = delete;

 private:
  std::array<char, 24> name_{"/tmp/tress-test-XXXXXX"};
  pid_t process_ = ::getpid();
};

const OwnFolder own_folder;

}  // namespace
