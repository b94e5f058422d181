// SPDX-License-Identifier: Apache-2.0
// Cyclone's internal state of a domain: sockets, threads and configuration. Included by source files of port/ only.
#pragma once

// Replaces a C header of Cyclone's: a typedef in it has the name of its struct, which C++ does not allow.
#define Q_SOCKWAITSET_H
using os_sockWaitset = struct SocketWaitSet*;
#include <dds/ddsi/ddsi_domaingv.h>
#include <dds/ddsi/ddsi_tran.h>
#include <dds/ddsi/q_thread.h>
#include <dds/ddsi/q_xevent.h>
