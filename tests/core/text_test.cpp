#include "core/text.hpp"

#include <gtest/gtest.h>

#include <string>

namespace qerr {
namespace {

TEST(Utf8, AcceptsWellFormedTextOnly) {
  for (const std::string good : {"a", "é", "€", "😀"}) EXPECT_EQ(utf8_length(good, 0), good.size());
  for (const std::string bad :
       {"\xC0\x80", "\xE0\x80\x80", "\xED\xA0\x80", "\xF4\x90\x80\x80", "\xF0\x9F\x98", "\x80", "\xFF"})
    EXPECT_EQ(utf8_length(bad, 0), 0u);
}

}  // namespace
}  // namespace qerr
