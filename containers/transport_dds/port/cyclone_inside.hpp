// SPDX-License-Identifier: Apache-2.0
// The inside of one of Cyclone's domains: its sockets, its threads and its state. Included inside port/ only, by its sources.
#pragma once

// This header of Cyclone's is C: a typedef in it has the name of its struct, which C++ does not allow.
#define Q_SOCKWAITSET_H
using os_sockWaitset = struct SocketWaitSet*;
#include <dds/ddsi/ddsi_domaingv.h>
#include <dds/ddsi/ddsi_tran.h>
#include <dds/ddsi/q_thread.h>
#include <dds/ddsi/q_xevent.h>
