// SPDX-License-Identifier: Apache-2.0
// Files of the MCAP project's conformance suite, made again from what its .json files say of them. Their SHA-256 are those of the suite.
// Source: foxglove/mcap @95d0673, tests/conformance/data (checksums: Git LFS pointers of the .mcap files).
#include <gtest/gtest.h>
#include <openssl/evp.h>

#include <functional>

#include "record/protocol/mcap_writer.hpp"
#include "seen_file.hpp"

namespace nacelle::record {
namespace {

std::string sha256_of(ByteView bytes) {
  Bytes digest(32);
  unsigned length = 0;
  EXPECT_EQ(::EVP_Digest(bytes.data(), bytes.size(), digest.data(), &length, ::EVP_sha256(), nullptr), 1);
  return to_hex(digest);
}

const Bytes kData{1, 2, 3};

struct Variant {
  const char* name;
  const char* sha256;
  std::size_t size;
  std::function<bool(McapWriter&)> fill;
};

bool add_example(McapWriter& writer) {
  const Bytes text{4, 5, 6};
  return writer.add_schema("Example", "c", std::string{as_text(text)}) == 1 &&
         writer.add_channel(1, "example", "a", {{"foo", "bar"}}) == 1;
}

const Variant kVariants[] = {
    {"NoData", "78aed9973f50c4ebc30a8eab27453f6e42b2984c4f402d57e002dafdf217b744", 156,
     [](McapWriter&) { return true; }},
    {"OneMessage", "c2dc0d4ef3f1ee615eccc5753b4c401878865d05fb58c12aa7086c3e5e147165", 603,
     [](McapWriter& writer) {
       return add_example(writer) && writer.write({1, 10, 2, 1, {kData}});
     }},
    {"OneSchemalessMessage", "e9b4aa6f672b611783230a6d642e50dcdf8620ee938226f8e86ca9f22ec64848", 487,
     [](McapWriter& writer) {
       return writer.add_channel(0, "example", "text", {}) == 1 && writer.write({1, 10, 2, 1, {kData}});
     }},
    {"TenMessages", "813c4eb55e1195e5af9482f60d9b214cd083a8805720ec1663812637d716e4d5", 1053,
     [](McapWriter& writer) {
       bool all = add_example(writer);
       std::uint32_t sequence = 0;
       for (const std::uint64_t at : {0, 2, 1, 3, 3, 5, 4, 7, 8, 9}) {
         all = all && writer.write({1, sequence, at, at, {kData}});
         ++sequence;
       }
       return all;
     }},
    {"OneAttachment", "14c5896f47973ccec3482a4dbb990d3a438da72a16cdeeb470b701cd90f7af65", 347,
     [](McapWriter& writer) {
       return writer.write_attachment({2, 1, "myFile", "application/octet-stream", {kData}, 0});
     }},
    {"OneMetadata", "6d7681e1536e3c61a0d9755b1b10b9a7ad4c2042855a839ce96c8c024bc64316", 262,
     [](McapWriter& writer) {
       return writer.write_metadata({"myMetadata", {{"foo", "bar"}}});
     }},
};

TEST(McapConformance, files_are_those_of_the_suite_byte_for_byte) {
  for (const Variant& variant : kVariants) {
    MemoryFile file;
    McapWriter writer{file, {.data_crc = true, .profile = "", .library = ""}};
    ASSERT_TRUE(writer.start() && variant.fill(writer) && writer.finish()) << variant.name;
    EXPECT_EQ(file.bytes.size(), variant.size) << variant.name;
    EXPECT_EQ(sha256_of(file.bytes), variant.sha256) << variant.name;
    EXPECT_TRUE(SeenFile{file}.problems.empty()) << variant.name;
  }
}

}  // namespace
}  // namespace nacelle::record
