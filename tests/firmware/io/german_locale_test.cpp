/// Numbers in files where the system writes 1,5 for 1.5. The programs keep the C locale; whoever embeds them may have set another.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <clocale>
#include <cstdio>
#include <cstdlib>

#include "firmware/io/output_file.hpp"
#include "firmware/io/text/json_writer.hpp"
#include "firmware/settings/board_file.hpp"
#include "tests/firmware/support/job_fixture.hpp"
#include "tests/slicer/support/slicing.hpp"

namespace plumbline::firmware {
namespace {

using ::testing::HasSubstr;

std::string one_and_a_half() {
  std::array<char, 8> text{};
  std::snprintf(text.data(), text.size(), "%.1f", 1.5);
  return text.data();
}

/// Makes a German locale in a folder of its own, since few systems have one.
class GermanLocale : public ::testing::Test {
 protected:
  void SetUp() override {
    const std::string command = "localedef -i de_DE -f UTF-8 " + (folder_ / "de_DE.UTF-8") + " > /dev/null 2>&1";
    if (std::system(command.c_str()) != 0) {  // NOLINT(concurrency-mt-unsafe): one thread
      GTEST_SKIP() << "localedef can't make a German locale here: install the package locales";
    }
    ::setenv("LOCPATH", (folder_ / ".").c_str(), 1);  // NOLINT(concurrency-mt-unsafe)
    ASSERT_NE(std::setlocale(LC_ALL, "de_DE.UTF-8"), nullptr);
    ASSERT_EQ(one_and_a_half(), "1,5") << "this locale proves nothing";
  }
  void TearDown() override {
    std::setlocale(LC_ALL, "C");
    ::unsetenv("LOCPATH");  // NOLINT(concurrency-mt-unsafe)
  }
  TemporaryFolder folder_;
};

TEST_F(GermanLocale, ChangesNoNumberThatIsRead) {
  const auto board = read_board_file(PLUMBLINE_SOURCE_DIR "/board/sim2k.toml");
  ASSERT_TRUE(board) << board.error().message();
  EXPECT_EQ(board->pixel_pitch_x_mm, 0.04725);
  std::string scan;
  for (const auto& p : sphere_scan(3000, 2)) {
    // By hand, because printf would write commas.
    for (const double value : {p.x, p.y, p.z}) {
      const long thousandths = std::lround(1000 * value);
      scan += (thousandths < 0 ? "-" : "") + std::to_string(std::labs(thousandths) / 1000) + "." +
              std::to_string(1000 + std::labs(thousandths) % 1000).substr(1) + " ";
    }
    scan += "\n";
  }
  testing::MemorySource source(scan, "ball.xyz");
  const testing::Slicing sliced(source, testing::settings_with_pitch(0.1F), std::size_t{32} << 20U);
  EXPECT_NEAR(sliced.report().placement.size_mm[0], 4, 0.05);
}

TEST_F(GermanLocale, ChangesNoNumberThatIsWritten) {
  const std::string path = folder_ / "x.json";
  auto file = OutputFile::create(path.c_str());
  ASSERT_TRUE(file);
  JsonWriter json(*file);
  json.value(0.05);
  ASSERT_TRUE(json.finish());
  EXPECT_EQ(read_text(path), "0.05\n");
}

}  // namespace
}  // namespace plumbline::firmware
