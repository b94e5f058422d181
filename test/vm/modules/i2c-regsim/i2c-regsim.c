// SPDX-License-Identifier: GPL-2.0-only OR Apache-2.0
// An I2C bus with simulated chips, for tests in a virtual machine. Unlike the kernel's i2c-stub it answers plain I2C_RDWR transfers, and it fails
// on request.
//
// By itself it has one chip of 256 registers, which are the file `regs` of the platform device. While a program has /dev/i2c-regsim open, that
// program is all chips: it reads a transfer
//     address (1 byte), bytes that are written to the chip (2, little-endian), bytes that are read from it (2), the bytes that are written
// and writes the answer
//     0, and the bytes that are read; or 1, alone: no chip acknowledged.
//
// Writing 0 to the platform device's file `plugged` takes the bus away as unplugging a USB adapter does: transfers fail, the node in /dev goes,
// and the adapter when the last program has closed it. Writing 1 brings it back; that waits for the old one's end, and fails after a minute.
#include <linux/completion.h>
#include <linux/i2c.h>
#include <linux/miscdevice.h>
#include <linux/module.h>
#include <linux/platform_device.h>
#include <linux/poll.h>
#include <linux/uaccess.h>
#include <linux/wait.h>
#include <linux/workqueue.h>

static unsigned int addr = 0x68;
module_param(addr, uint, 0644);
MODULE_PARM_DESC(addr, "address of the chip");
static unsigned int nak_every;
module_param(nak_every, uint, 0644);
MODULE_PARM_DESC(nak_every, "every n-th transfer is not acknowledged; 0: none");
static bool stuck;
module_param(stuck, bool, 0644);
MODULE_PARM_DESC(stuck, "transfers time out, as on a bus that a chip holds low");
static unsigned int transfers;
module_param(transfers, uint, 0444);
MODULE_PARM_DESC(transfers, "how many there have been");

static u8 regs[256];
static u8 pointer;
static struct platform_device *device;
static bool plugged;
static DECLARE_COMPLETION(gone);

/* The program that is the chips, and the transfer that it is asked for. The I2C core lets one transfer at a time in. */
#define HEADER 5
#define MOST 1024
static DEFINE_MUTEX(lock);
static DECLARE_WAIT_QUEUE_HEAD(changed);
static enum { IDLE, ASKED, TAKEN, ANSWERED } state;
static bool has_program;
static u8 question[HEADER + MOST], answer[1 + MOST];
static size_t question_size, answer_size;

static int ask(struct i2c_msg *messages, int count)
{
	struct i2c_msg *out = messages[0].flags & I2C_M_RD ? NULL : &messages[0];
	struct i2c_msg *in = messages[count - 1].flags & I2C_M_RD ? &messages[count - 1] : NULL;
	int result = count;

	if (count > 2 || (count == 2 && (!out || !in)) || (out && out->len > MOST) || (in && in->len > MOST))
		return -EOPNOTSUPP;
	mutex_lock(&lock);
	question[0] = messages[0].addr;
	question[1] = out ? out->len & 0xFF : 0;
	question[2] = out ? out->len >> 8 : 0;
	question[3] = in ? in->len & 0xFF : 0;
	question[4] = in ? in->len >> 8 : 0;
	if (out)
		memcpy(question + HEADER, out->buf, out->len);
	question_size = HEADER + (out ? out->len : 0);
	state = ASKED;
	mutex_unlock(&lock);
	wake_up_all(&changed);
	wait_event_timeout(changed, READ_ONCE(state) == ANSWERED || !READ_ONCE(has_program), 20 * HZ);
	mutex_lock(&lock);
	if (state != ANSWERED)
		result = -ETIMEDOUT;
	else if (answer[0] || answer_size != 1 + (in ? in->len : 0))
		result = -ENXIO;
	else if (in)
		memcpy(in->buf, answer + 1, in->len);
	state = IDLE;
	mutex_unlock(&lock);
	return result;
}

static int program_open(struct inode *inode, struct file *file)
{
	int result = 0;

	mutex_lock(&lock);
	if (has_program)
		result = -EBUSY;
	WRITE_ONCE(has_program, true);
	mutex_unlock(&lock);
	return result;
}

static int program_release(struct inode *inode, struct file *file)
{
	WRITE_ONCE(has_program, false);
	wake_up_all(&changed);
	return 0;
}

static ssize_t program_read(struct file *file, char __user *buffer, size_t size, loff_t *offset)
{
	ssize_t result = -EAGAIN;

	mutex_lock(&lock);
	if (state == ASKED && size < question_size) {
		result = -EINVAL;
	} else if (state == ASKED) {
		result = copy_to_user(buffer, question, question_size) ? -EFAULT : question_size;
		state = TAKEN;
	}
	mutex_unlock(&lock);
	return result;
}

static ssize_t program_write(struct file *file, const char __user *buffer, size_t size, loff_t *offset)
{
	ssize_t result = -EINVAL;

	mutex_lock(&lock);
	if (state == TAKEN && size >= 1 && size <= sizeof(answer) && !copy_from_user(answer, buffer, size)) {
		answer_size = size;
		WRITE_ONCE(state, ANSWERED);
		result = size;
	}
	mutex_unlock(&lock);
	wake_up_all(&changed);
	return result;
}

static __poll_t program_poll(struct file *file, poll_table *table)
{
	poll_wait(file, &changed, table);
	return READ_ONCE(state) == ASKED ? EPOLLIN : 0;
}

static const struct file_operations program_operations = {
	.owner = THIS_MODULE,
	.open = program_open,
	.release = program_release,
	.read = program_read,
	.write = program_write,
	.poll = program_poll,
};

static struct miscdevice program_device = {
	.minor = MISC_DYNAMIC_MINOR,
	.name = "i2c-regsim",
	.fops = &program_operations,
};

static int transfer(struct i2c_adapter *adapter, struct i2c_msg *messages, int count)
{
	int i, k;

	if (!READ_ONCE(plugged))
		return -ENODEV;
	transfers++;
	if (stuck)
		return -ETIMEDOUT;
	if (nak_every && transfers % nak_every == 0)
		return -ENXIO;
	if (READ_ONCE(has_program))
		return ask(messages, count);
	for (i = 0; i < count; i++) {
		struct i2c_msg *message = &messages[i];

		if (message->addr != addr)
			return -ENXIO;
		for (k = 0; k < message->len; k++) {
			if (message->flags & I2C_M_RD)
				message->buf[k] = regs[pointer++];
			else if (k == 0)
				pointer = message->buf[0];
			else
				regs[pointer++] = message->buf[k];
		}
	}
	return count;
}

static u32 functionality(struct i2c_adapter *adapter)
{
	return I2C_FUNC_I2C | I2C_FUNC_SMBUS_EMUL;
}

static const struct i2c_algorithm algorithm = {
	.master_xfer = transfer,
	.functionality = functionality,
};

static struct i2c_adapter adapter = {
	.owner = THIS_MODULE,
	.algo = &algorithm,
	.name = "regsim",
};

static ssize_t read_regs(struct file *file, struct kobject *object, struct bin_attribute *attribute, char *buffer,
			 loff_t offset, size_t size)
{
	memcpy(buffer, regs + offset, size);
	return size;
}

static ssize_t write_regs(struct file *file, struct kobject *object, struct bin_attribute *attribute, char *buffer,
			  loff_t offset, size_t size)
{
	memcpy(regs + offset, buffer, size);
	return size;
}

static struct bin_attribute regs_file = {
	.attr = { .name = "regs", .mode = 0644 },
	.size = sizeof(regs),
	.read = read_regs,
	.write = write_regs,
};

static int plug(void)
{
	int result;

	adapter.dev.parent = &device->dev;
	WRITE_ONCE(plugged, true);
	result = i2c_add_adapter(&adapter);
	if (result)
		WRITE_ONCE(plugged, false);
	return result;
}

/* Waits for every program that has the adapter open. */
static void remove_adapter(struct work_struct *work)
{
	i2c_del_adapter(&adapter);
	complete(&gone);
}
static DECLARE_WORK(removal, remove_adapter);

static ssize_t plugged_show(struct device *dev, struct device_attribute *attribute, char *buffer)
{
	return sysfs_emit(buffer, "%d\n", plugged);
}

static ssize_t plugged_store(struct device *dev, struct device_attribute *attribute, const char *buffer, size_t size)
{
	bool wish;
	int result = kstrtobool(buffer, &wish);

	if (result)
		return result;
	if (wish == plugged)
		return size;
	if (!wish) {
		WRITE_ONCE(plugged, false);
		schedule_work(&removal);
		return size;
	}
	if (!wait_for_completion_timeout(&gone, 60 * HZ))
		return -EBUSY;
	result = plug();
	if (result)
		complete(&gone);
	return result ? result : size;
}
static DEVICE_ATTR_RW(plugged);

static int __init begin(void)
{
	int result;

	device = platform_device_register_simple("i2c-regsim", -1, NULL, 0);
	if (IS_ERR(device))
		return PTR_ERR(device);
	result = plug();
	if (result)
		goto no_adapter;
	result = sysfs_create_bin_file(&device->dev.kobj, &regs_file);
	if (result)
		goto no_file;
	result = device_create_file(&device->dev, &dev_attr_plugged);
	if (result)
		goto no_attribute;
	result = misc_register(&program_device);
	if (result)
		goto no_program;
	return 0;

no_program:
	device_remove_file(&device->dev, &dev_attr_plugged);
no_attribute:
	sysfs_remove_bin_file(&device->dev.kobj, &regs_file);
no_file:
	i2c_del_adapter(&adapter);
no_adapter:
	platform_device_unregister(device);
	return result;
}

static void __exit end(void)
{
	misc_deregister(&program_device);
	device_remove_file(&device->dev, &dev_attr_plugged);
	sysfs_remove_bin_file(&device->dev.kobj, &regs_file);
	flush_work(&removal);
	if (plugged)
		i2c_del_adapter(&adapter);
	platform_device_unregister(device);
}

module_init(begin);
module_exit(end);
MODULE_LICENSE("GPL");
MODULE_DESCRIPTION("I2C bus with simulated chips");
