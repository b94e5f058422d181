// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <dds/dds.h>

/// A type under another name, which then decides alone: the type information of XTypes would contradict it. The members of a
/// descriptor are constants, so it is made anew.
inline dds_topic_descriptor_t without_xtypes(const dds_topic_descriptor_t& type, const char* name) {
  return {.m_size = type.m_size,
          .m_align = type.m_align,
          .m_flagset = type.m_flagset & ~DDS_TOPIC_XTYPES_METADATA,
          .m_nkeys = type.m_nkeys,
          .m_typename = name,
          .m_keys = type.m_keys,
          .m_nops = type.m_nops,
          .m_ops = type.m_ops,
          .m_meta = type.m_meta};
}
